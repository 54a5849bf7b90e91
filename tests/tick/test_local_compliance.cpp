// SPDX-License-Identifier: GPL-3.0-or-later
// The give around a needle that a mesh does not resolve: its closed forms, and what it does to forces.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "server/engine/models/unresolved/local_compliance.h"
#include "tests/tick/bench.h"

namespace acus::test {
namespace {

constexpr double kDiameter = 1e-3;  // m

Material gel() {
  Material material;
  material.young_modulus = 20e3;
  material.poisson_ratio = 0.45;
  return material;
}

// A rigid needle on the bench's block of `cells`³.
Scene give_scene(LocalCompliance give, int cells = 6) {
  Scene scene = block_scene();
  scene.tissue.local_compliance = give;
  scene.tissue.box.cells.fill(cells);
  scene.tissue.regions[0].material.rayleigh_stiffness = 0;
  scene.needles[0].rung = NeedleRung::rigid;
  scene.needles[0].outer_diameter = kDiameter;
  scene.needles[0].smoothing = 0;
  return scene;
}

// Travel (m) from contact to puncture.
double puncture_depth(LocalCompliance give, int cells) {
  Bench bench(give_scene(give, cells));
  bench.push(0, 0.012, 0.02);
  REQUIRE(bench.events(EventKind::puncture).size() == 1);
  const Event contact = bench.events(EventKind::contact)[0], puncture = bench.events(EventKind::puncture)[0];
  return contact.position.z() - puncture.position.z();
}

TEST_CASE("along the shaft: the give between two element sizes is that of a line load, none below the needle's size") {
  const double G = 20e3 / 2.9;
  const double coarse = axial_compliance(gel(), 20e-3, kDiameter), fine = axial_compliance(gel(), 5e-3, kDiameter);
  CHECK(coarse - fine == doctest::Approx(std::log(4) / (2 * std::numbers::pi * G)).epsilon(1e-9).scale(0));
  CHECK(fine > 0);
  CHECK(axial_compliance(gel(), 1e-3, kDiameter) == 0);
}

TEST_CASE("ahead of the tip: the give between two element sizes is that of a point load, none below the needle's size") {
  const double small = 1e-9;  // N: the needle's radius counts
  const double E = 20e3, nu = 0.45, G = E / (2 * (1 + nu));
  const double inside = tip_compliance(gel(), kInfinity, kDiameter, small);
  CHECK(inside == doctest::Approx((5 - 6 * nu) / (24 * std::numbers::pi * G * (1 - nu)) * 2 / kDiameter));
  CHECK(tip_compliance(gel(), 0.8e-3, kDiameter, small) == 0);
  const auto part = [&](double edge) { return inside - tip_compliance(gel(), edge, kDiameter, small); };
  CHECK(part(4e-3) == doctest::Approx(2 * part(8e-3)).epsilon(1e-9).scale(0));
}

TEST_CASE("however large the force, the give ahead of a tip stays below a quarter of the element") {
  for (const double f : {1e-3, 0.1, 1.0, 30.0, 1e4})
    for (const double edge : {2e-3, 5e-3, 20e-3}) CHECK(f * tip_compliance(gel(), edge, kDiameter, f) <= 0.25 * edge);
}

TEST_CASE("the depth of puncture hardly depends on the mesh, and not on what is added inside") {
  const double depth = puncture_depth(LocalCompliance::all, 6);
  CHECK(puncture_depth(LocalCompliance::all, 3) == doctest::Approx(depth).epsilon(0.04).scale(0));
  CHECK(puncture_depth(LocalCompliance::all, 9) == doctest::Approx(depth).epsilon(0.09).scale(0));
  CHECK(puncture_depth(LocalCompliance::none, 6) == depth);
}

TEST_CASE("a shaft that sticks gives back what it took: closed cycles cost no energy") {
  Scene scene = give_scene(LocalCompliance::all);
  Interaction& law = scene.tissue.regions[0].interaction;
  law.cutting_force = law.puncture_force = 1e-3;
  Bench bench(scene);
  bench.push(0, 0.04, 0.1);
  bench.push(0, -0.05e-3, 0.01);  // away from the threshold, where nothing slips
  bench.wait(0.5);
  const double force = bench.resistance(), energy = bench.simulation().energy().elastic;
  double other_force = 0, other_energy = 0, depth = bench.needle().inserted_depth;
  for (int cycle = 0; cycle < 3; ++cycle) {
    bench.push(0, -0.05e-3, 0.01);
    bench.wait(0.1);
    other_force = bench.resistance(), other_energy = bench.simulation().energy().elastic;
    bench.push(0, 0.05e-3, 0.01);
    bench.wait(0.5);
  }
  CHECK(bench.needle().inserted_depth == doctest::Approx(depth));
  CHECK(other_force < 0.97 * force);
  CHECK(bench.resistance() == doctest::Approx(force).epsilon(1e-4));
  CHECK(bench.simulation().energy().elastic == doctest::Approx(energy).epsilon(2e-8).scale(0));
  // What went out on the way is the work of the base, with a force that falls linearly.
  CHECK(energy - other_energy == doctest::Approx(0.5 * (force + other_force) * 0.05e-3).epsilon(5e-3).scale(0));
}

TEST_CASE(
    "the give along the shaft makes it softer against a small pull, not, by its length inside, against a steady one") {
  const auto drop = [](LocalCompliance give, double& steady) {  // steady: N/m
    Scene scene = give_scene(give);
    scene.tissue.regions[0].interaction.cutting_force = 0;
    Bench bench(scene);
    bench.push(0, 0.04, 0.1);
    bench.wait(0.2);
    steady = bench.resistance() / bench.needle().inserted_depth;
    const double before = bench.resistance();
    bench.push(0, -0.02e-3, 0.01);
    bench.wait(0.2);
    return before - bench.resistance();
  };
  double without = 0, with = 0;
  const double stiff = drop(LocalCompliance::none, without), soft = drop(LocalCompliance::all, with);
  CHECK(with == doctest::Approx(without).epsilon(2e-4).scale(0));
  CHECK(soft < 0.85 * stiff);
  CHECK(soft > 0.3 * stiff);
}

// Largest change of the resistance from tick to tick while the needle goes on by 10 mm, through elements and past
// vertices.
double roughness(LocalCompliance give, LawMethod method, double speed, std::vector<double>* forces = nullptr) {
  Scene scene = give_scene(give);
  scene.laws.solver = method;
  scene.laws.tolerance = 1e-8;
  Bench bench(scene);
  bench.push(0, 0.03, std::abs(speed));
  if (speed < 0) bench.push(0, -0.008, -speed);
  double last = bench.resistance(), largest = 0;
  bench.each_tick = [&] {
    largest = std::max(largest, std::abs(bench.resistance() - last));
    last = bench.resistance();
    if (forces) forces->push_back(last);
  };
  bench.push(0, std::copysign(0.01, speed), std::abs(speed));
  CHECK(bench.flags() == 0);
  return largest;
}

TEST_CASE("no vertex that comes or goes, and no element, makes the force jump" * doctest::test_suite("gate")) {
  for (const double speed : {0.02, -0.02}) {
    CAPTURE(speed);
    const double bare = roughness(LocalCompliance::none, LawMethod::direct, speed);
    CHECK(roughness(LocalCompliance::all, LawMethod::direct, speed) < std::max(1.5 * bare, 6e-4));
  }
}

TEST_CASE("both solvers give the same forces with springs in series") {
  std::vector<double> direct, sweeps;
  roughness(LocalCompliance::all, LawMethod::direct, 0.04, &direct);
  roughness(LocalCompliance::all, LawMethod::gauss_seidel, 0.04, &sweeps);
  REQUIRE(direct.size() == sweeps.size());
  double largest = 0;
  for (std::size_t i = 0; i < direct.size(); ++i) largest = std::max(largest, std::abs(direct[i] - sweeps[i]));
  CHECK(largest < 1e-9);
}

TEST_CASE("a tip that gives way sideways does not creep: it comes back to where it was") {
  Scene scene = give_scene(LocalCompliance::all);
  scene.needles[0].rung = NeedleRung::flexible;
  Bench bench(scene);
  bench.push(0, 0.03, 0.04);
  bench.wait(0.2);
  const Vector3 before = bench.needle().tip_position;
  bench.move(0, Vector3(2e-3, 0, 0), 0.04);
  bench.wait(0.2);
  const Vector3 early = bench.needle().tip_position;
  bench.wait(1);
  CHECK((bench.needle().tip_position - early).norm() < 1e-9);
  bench.move(0, Vector3(-2e-3, 0, 0), 0.04);
  bench.wait(0.5);
  CHECK((bench.needle().tip_position - before).head<2>().norm() < 0.02 * (early - before).head<2>().norm() + 1e-6);
}

}  // namespace
}  // namespace acus::test
