// SPDX-License-Identifier: GPL-3.0-or-later
// Shafts that touch surfaces beside their paths: a needle on the skin, over an edge, upright in its path.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "server/engine/state/bytes/state_check.h"
#include "server/engine/state/limits.h"
#include "tests/tick/bench.h"

namespace acus::test {
namespace {

constexpr double kSpeed = 0.02;  // m/s

// A block on its base, 120 x 120 x 60 mm, its top at z = 30 mm, and a needle along x, 1 mm above it.
Scene lying_scene(int cells = 12) {
  Scene scene = block_scene();
  scene.tissue.box = {Vector3(0.12, 0.12, 0.06), {cells, cells, cells / 2}};
  Volume bottom;
  bottom.half_space = HalfSpace{Vector3(0, 0, -0.0299), Vector3::UnitZ()};
  scene.tissue.fixed = {bottom};
  Material& material = scene.tissue.regions[0].material;
  material.young_modulus = 10e3;
  material.rayleigh_stiffness = 0.01;
  scene.tissue.regions[0].interaction.friction_contact = 0;
  scene.tissue.regions[0].interaction.puncture_force = 3;
  Needle& needle = scene.needles[0];
  needle.rung = NeedleRung::rigid;
  needle.length = 0.06;
  needle.outer_diameter = 1e-3;
  needle.base = {Vector3(-0.03, 0.0021, 0.031), Quaternion::Identity()};
  return scene;
}

const std::vector<ShaftCell>& cells(const Bench& bench) { return bench.simulation().state().insertions[0].cells; }

double borne(const Bench& bench) {
  double sum = 0;
  for (const ShaftCell& cell : cells(bench)) sum += cell.contact.along;
  return sum;
}

// N, up.
double lift(const Bench& bench) { return bench.needle().base_force.z(); }

double largest_step(Bench& bench, const std::function<void()>& motion) {
  Vector3 before = bench.needle().base_force;
  double largest = 0;
  bench.each_tick = [&] {
    largest = std::max(largest, (bench.needle().base_force - before).norm());
    before = bench.needle().base_force;
  };
  motion();
  bench.each_tick = nullptr;
  return largest;
}

}  // namespace

TEST_CASE("a needle laid on the skin is borne by it, and free again when it is lifted") {
  Bench bench(lying_scene());
  bench.move(0, Vector3(0, 0, -2e-3), kSpeed);
  bench.wait(0.3);
  const double tip = bench.needle().tip_force.z();
  CHECK(lift(bench) > 0.2);
  CHECK(borne(bench) + tip == doctest::Approx(lift(bench)).epsilon(0.02));
  CHECK(bench.needle().lateral_force.z() == doctest::Approx(borne(bench)).epsilon(1e-6));
  CHECK(bench.needle().unheld == 0);
  bench.move(0, Vector3(0, 0, 3e-3), kSpeed);
  bench.wait(0.1);
  CHECK(borne(bench) == 0);
  CHECK(std::abs(lift(bench)) < 1e-9);
  CHECK((bench.flags() & ~kBaseLimited) == 0);
}

TEST_CASE("skin that is fixed bears a lying needle as softly as its material, on any mesh") {
  for (const int cells : {6, 24}) {
    CAPTURE(cells);
    Scene scene = lying_scene(cells);
    scene.tissue.local_compliance = LocalCompliance::all;
    Bench free_skin(scene);
    Volume top;
    top.half_space = HalfSpace{Vector3(0, 0, 0.0299), -Vector3::UnitZ()};
    scene.tissue.fixed.push_back(top);
    Bench fixed(scene);
    for (Bench* bench : {&free_skin, &fixed}) bench->move(0, Vector3(0, 0, -3e-3), kSpeed);
    CHECK(lift(fixed) > 0.6 * lift(free_skin));
    CHECK(lift(fixed) < 2 * lift(free_skin));
  }
}

TEST_CASE("a shaft that is found deep is held from there, and comes out freely") {
  Scene scene = lying_scene();
  scene.needles[0].length = 0.16;
  scene.needles[0].base.position = {-0.08, 0.0021, 0.025};  // 5 mm under the top, from side to side
  Bench bench(scene);
  bench.wait(0.01);
  const double still = std::abs(lift(bench));
  CHECK(still < 0.5);
  bench.move(0, Vector3(0, 0, 2e-3), kSpeed);
  CHECK(borne(bench) == 0);
  CHECK(bench.needle().unheld < 2 * 5e-3);  // what is nearer to the sides, which it meets upright
  bench.move(0, Vector3(0, 0, -1e-3), kSpeed);
  CHECK(lift(bench) > 0.2);
  bench.move(0, Vector3(0, 0, 6e-3), kSpeed);
  bench.wait(0.1);
  CHECK(std::abs(lift(bench)) < 1e-9);
}

TEST_CASE("what bears a lying needle depends little on the mesh" * doctest::test_suite("gate")) {
  double force[2];
  const int cells[2] = {6, 12};
  for (int k = 0; k < 2; ++k) {
    Bench bench(lying_scene(cells[k]));
    bench.move(0, Vector3(0, 0, -2e-3), kSpeed);
    bench.wait(0.3);
    force[k] = borne(bench);
  }
  CHECK(force[1] == doctest::Approx(force[0]).epsilon(0.05));
}

TEST_CASE("a needle that is dragged over the skin has the friction of its cone, in any direction" *
          doctest::test_suite("gate")) {
  Scene scene = lying_scene();
  const double mu = 0.3;
  scene.tissue.regions[0].interaction.friction_contact = mu;
  for (const Vector3& way : {Vector3(0.01, 0, 0), Vector3(0, 0.01, 0), Vector3(-6e-3, 8e-3, 0)}) {
    Bench bench(scene);
    bench.move(0, Vector3(0, 0, -2e-3), kSpeed);
    double excess = 0;
    bench.each_tick = [&] {
      for (const ShaftCell& cell : cells(bench))
        excess = std::max(excess, cell.contact.across.norm() - mu * cell.contact.along - 1e-9);
    };
    bench.move(0, way, kSpeed);
    CHECK(excess < 1e-6);
    Vector3 friction = Vector3::Zero();
    for (const ShaftCell& cell : cells(bench)) friction += cell.contact.across;
    CHECK(friction.dot(way.normalized()) == doctest::Approx(-mu * borne(bench)).epsilon(0.03));
  }
}

TEST_CASE("a needle that slides lengthwise over an edge of the body is borne without jumps" *
          doctest::test_suite("gate")) {
  for (const LocalCompliance compliance : {LocalCompliance::all, LocalCompliance::none}) {
    CAPTURE(compliance == LocalCompliance::all);
    Scene scene = lying_scene();
    scene.tissue.local_compliance = compliance;
    scene.needles[0].length = 0.1;  // reaches over the edge at x = 60 mm
    Bench bench(scene);
    bench.move(0, Vector3(0, 0, -2.5e-3), kSpeed);
    bench.wait(0.2);
    const double before = lift(bench);
    CHECK(before > 0.2);
    const double step = largest_step(bench, [&] { bench.move(0, Vector3(0.05, 0, 0), kSpeed); });
    CHECK(step < 0.01 * before + 0.01);
    CHECK(bench.needle().unheld == 0);
  }
}

TEST_CASE("a needle shorter than a cell is borne, too") {
  Scene scene = lying_scene();
  scene.needles[0].length = 5e-3;
  Bench bench(scene);
  bench.move(0, Vector3(0, 0, -2e-3), kSpeed);
  CHECK(bench.finite());
  CHECK(lift(bench) > 0.01);
}

TEST_CASE("a state of a needle that lies on the skin is good, a forged one is refused") {
  Bench bench(lying_scene());
  bench.move(0, Vector3(0, 0, -2e-3), kSpeed);
  const Model& model = bench.simulation().model();
  const State& state = bench.simulation().state();
  CHECK_NOTHROW(check_state(model, state));
  const auto refused = [&](auto forge) {
    State forged = state;
    forge(forged.insertions[0].cells[2]);
    CHECK_THROWS_AS(check_state(model, forged), std::runtime_error);
  };
  REQUIRE(state.insertions[0].cells[2].contact.along > 0);
  refused([](ShaftCell& cell) { cell.length = 0; });
  refused([](ShaftCell& cell) { cell.length = 1e-310; });
  refused([](ShaftCell& cell) { cell.contact.along = -1; });
  refused([](ShaftCell& cell) { cell.normal.setZero(); });
  refused([](ShaftCell& cell) { cell.moved = 1e3; });
  refused([](ShaftCell& cell) { cell.s = 1; });
}

TEST_CASE("a shaft that goes in upright has no contact beside its path") {
  Bench bench(block_scene());
  double length = 0;
  bench.each_tick = [&] {
    for (const ShaftCell& cell : cells(bench)) length = std::max(length, cell.length);
  };
  bench.push(0, 0.03, kSpeed);
  REQUIRE(bench.needle().phase == Phase::inside);
  CHECK(length == 0);
}

TEST_CASE("far from the surface nothing is looked for") {
  Scene scene = lying_scene();
  scene.needles[0].base.position.z() = 0.08;
  Bench bench(scene);
  bench.wait(0.01);
  const auto looked_from = [&] { return cells(bench)[3].looked_from; };
  const Vector3 first = looked_from();
  bench.move(0, Vector3(0, 0, -0.03), 0.2);
  CHECK(looked_from() == first);
  bench.move(0, Vector3(0, 0, -0.0195), 0.2);
  CHECK(looked_from() != first);
}

}  // namespace acus::test
