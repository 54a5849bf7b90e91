// SPDX-License-Identifier: GPL-3.0-or-later
// Worlds that begin in equilibrium: a rod's sag and pressure's strain in closed form, and nothing moves from then on.
#include <doctest/doctest.h>

#include <numbers>

#include "server/engine/math/largest_move.h"
#include "server/engine/scene/field_error.h"
#include "server/engine/scene/scene_fields.h"
#include "server/engine/state/bytes/snapshot.h"
#include "server/engine/state/bytes/state_bytes.h"
#include "server/engine/state/placement.h"
#include "server/engine/tick/static_start.h"
#include "tests/tick/bench.h"

namespace acus::test {
namespace {

constexpr double kModulus = 5e3, kHeight = 0.06, kDensity = 1060;

// A block on a plate, its weight acting, and a needle above it.
Scene standing_block(double poisson_ratio = 0.45) {
  Scene scene = block_scene(kHeight);
  scene.gravity = {0, 0, -9.81};
  scene.start = Start::equilibrium;
  scene.tissue.fixed.assign(1, {});
  scene.tissue.fixed[0].half_space = HalfSpace{{0, 0, -kHeight / 2}, {0, 0, 1}};
  Material& material = scene.tissue.regions[0].material;
  material = {kModulus, poisson_ratio, kDensity, 0, 0.01};
  return scene;
}

Pressure on_top(double pressure) {
  Pressure pressed;
  pressed.half_space = HalfSpace{{0, 0, kHeight / 2 - 1e-6}, {0, 0, -1}};
  pressed.pressure = pressure;
  return pressed;
}

// Mean of the nodes at a height of the undeformed block (m, downwards).
double sunk(const Simulation& simulation, double height) {
  const Matrix3X& rest = simulation.mesh().nodes;
  double sum = 0;
  int nodes = 0;
  for (Eigen::Index i = 0; i < rest.cols(); ++i) {
    if (std::abs(rest(2, i) - height) > 1e-9) continue;
    sum += rest(2, i) - simulation.tissue_positions()(2, i);
    ++nodes;
  }
  return sum / nodes;
}

// What moves (m, of tissue and needles) in so many ticks after the start.
double stirred(const Scene& scene, int ticks = 500) {
  Simulation simulation(scene);
  const State start = simulation.state();
  double most = 0;
  for (int tick = 0; tick < ticks; ++tick) {
    simulation.step();
    CHECK(simulation.report().flags == 0);
    CHECK(simulation.report().events.empty());
    most = std::max(most, largest_move(start.tissue.x, simulation.state().tissue.x));
    for (std::size_t i = 0; i < start.needles.size(); ++i)
      most = std::max(most, largest_move(start.needles[i].x, simulation.state().needles[i].x));
  }
  return most;
}

// Whether its bytes are taken as a state of the scene, and are the same state.
bool goes_on_from_snapshot(const Simulation& simulation) {
  const State read = read_snapshot(simulation.model(), make_snapshot(simulation.model().fingerprint, simulation.state()));
  return hash(read) == hash(simulation.state());
}

std::string refusal(const Scene& scene) {
  try {
    const Simulation simulation(scene);
  } catch (const SceneError& error) {
    return error.what();
  }
  return "";
}

}  // namespace

TEST_CASE("a block without narrowing begins as far sunk as a rod under its weight and a pressure") {
  Scene scene = standing_block(0);
  scene.tissue.rung = TissueRung::linear;
  const double rod = kDensity * 9.81 * kHeight * kHeight / (2 * kModulus);
  CHECK(sunk(Simulation(scene), kHeight / 2) == doctest::Approx(rod).epsilon(0.01).scale(0));
  scene.gravity.setZero();
  scene.tissue.pressures = {on_top(300), on_top(200)};
  const Simulation pressed(scene);
  for (const double height : {-0.01, 0.02, 0.03})
    CHECK(sunk(pressed, height) == doctest::Approx(500 / kModulus * (height + kHeight / 2)).epsilon(1e-6).scale(0));
}

TEST_CASE("a pressure acts along the normals of the faces that it selects") {
  Scene scene = standing_block();
  scene.tissue.pose.orientation = Quaternion(Eigen::AngleAxisd(0.4, Vector3(1, 2, 0.5).normalized()));
  const TetrahedralMesh mesh = load_mesh(scene);
  scene.tissue.pressures = {on_top(1000)};
  const Vector3 up = scene.tissue.pose.orientation * Vector3::UnitZ();
  CHECK((pressure_forces(scene, mesh).rowwise().sum() + 1000 * 0.06 * 0.06 * up).norm() < 1e-12);
  scene.tissue.pressures[0].pressure = -1000;
  CHECK((pressure_forces(scene, mesh).rowwise().sum() - 1000 * 0.06 * 0.06 * up).norm() < 1e-12);
  scene.tissue.pressures[0].half_space.reset();
  scene.tissue.pressures[0].box = Box{};  // the whole surface
  const Matrix3X all_round = pressure_forces(scene, mesh);
  CHECK(all_round.rowwise().sum().norm() < 1e-12);
  double virial = 0;  // sum of f x: the pressure times three volumes
  for (Eigen::Index i = 0; i < mesh.nodes.cols(); ++i) virial += all_round.col(i).dot(mesh.nodes.col(i));
  CHECK(virial == doctest::Approx(3 * 1000 * 0.06 * 0.06 * kHeight).epsilon(1e-9).scale(0));
}

TEST_CASE("nothing moves after a start in equilibrium, whatever solves the tissue" * doctest::test_suite("gate")) {
  for (const TissueRung rung : {TissueRung::linear, TissueRung::warped, TissueRung::refined, TissueRung::exact}) {
    CAPTURE(name_of(rung));
    Scene scene = standing_block();
    scene.tissue.rung = rung;
    scene.tissue.pressures = {on_top(150)};
    CHECK(stirred(scene, rung == TissueRung::exact ? 50 : 500) < 20e-9);
  }
  Scene scene = standing_block();
  scene.tissue.element = TissueElement::nodal_pressure;
  scene.tissue.regions[0].material.poisson_ratio = 0.495;
  CHECK(stirred(scene) < 20e-9);
}

TEST_CASE("a rod that is pulled to half its length more begins at rest: rounding has no say in its last steps") {
  for (const double share : {0.1, 0.15, 0.2, 0.25, 0.3, 0.35, 0.4, 0.5, 0.6}) {
    CAPTURE(share);
    Scene scene = standing_block();
    scene.gravity.setZero();
    scene.tissue.rung = TissueRung::warped;
    scene.tissue.box.size = {0.02, 0.02, 0.1};
    scene.tissue.box.cells = {2, 2, 10};
    scene.tissue.fixed[0].half_space = HalfSpace{{0, 0, -0.0499}, {0, 0, 1}};
    Pressure& end = scene.tissue.pressures.emplace_back();
    end.half_space = HalfSpace{{0, 0, 0.0499}, {0, 0, -1}};
    end.pressure = -share * kModulus;
    scene.needles = {needle_at({0, 0, 0.2}, 0.005)};
    CHECK(stirred(scene, 50) < 20e-9);
  }
}

TEST_CASE("nothing moves after a start in equilibrium of tissue that relaxes or has a deferred field" *
          doctest::test_suite("gate")) {
  Scene scene = standing_block();
  scene.tissue.regions[0].material.relaxation = {{1.5, 0.2}, {0.5, 3000}};
  CHECK(stirred(scene, 2000) < 20e-9);
  scene = standing_block();
  for (const int window : {1, 16}) {
    scene.tissue.window = window;
    CHECK(stirred(scene, 400) < 50e-9);
  }
}

TEST_CASE("tissue that hangs by its side, and a long needle, begin where they would come to rest") {
  Scene scene = standing_block();
  scene.tissue.fixed[0].half_space = HalfSpace{{-0.03, 0, 0}, {1, 0, 0}};
  scene.tissue.regions[0].material.rayleigh_mass = 20;
  scene.needles[0] = needle_at({0.01, 0.012, kHeight / 2}, 0.05);
  scene.needles[0].base = {{-0.1, 0, 0.2}, Quaternion::Identity()};
  scene.needles[0].length = 0.3;
  scene.needles[0].material.rayleigh_mass = 20;
  CHECK(stirred(scene) < 50e-9);
  const Simulation settled(scene);
  CHECK(largest_move(settled.mesh().nodes, settled.state().tissue.x) > 5e-3);
  const double bent = scene.needles[0].base.position.z() - settled.state().needles[0].x.col(scene.needles[0].beams).z();
  const double mass = scene.needles[0].material.density * std::numbers::pi / 4 * std::pow(scene.needles[0].outer_diameter, 2);  // per m
  const double stiffness = 200e9 * std::numbers::pi / 64 * std::pow(scene.needles[0].outer_diameter, 4);
  CHECK(bent == doctest::Approx(mass * 9.81 * std::pow(0.3, 4) / (8 * stiffness)).epsilon(0.02).scale(0));
  scene.start = Start::undeformed;
  scene.rate = 100;
  Simulation falling(scene);
  for (int tick = 0; tick < 600; ++tick) falling.step();
  CHECK(largest_move(settled.state().tissue.x, falling.state().tissue.x) < 1e-6);
  CHECK(largest_move(settled.state().needles[0].x, falling.state().needles[0].x) < 1e-6);
}

TEST_CASE("a needle that the tissue comes to lie against is in equilibrium with it") {
  Scene scene = standing_block();
  scene.gravity = {0, 0, 9.81};  // upwards
  scene.tissue.regions[0].interaction.puncture_force = 5;
  scene.needles[0] = needle_at({0.004, 0.006, kHeight / 2}, 1e-3);
  Simulation simulation(scene);
  CHECK(simulation.report().needles[0].phase == Phase::contact);
  CHECK(goes_on_from_snapshot(simulation));
  const double sunk_in = simulation.report().needles[0].tip_position.z();
  simulation.step();
  const Vector3 force = simulation.report().needles[0].tip_force;
  CHECK(force.z() > 0.02);
  CHECK(stirred(scene) < 1e-6);
  for (int tick = 0; tick < 500; ++tick) simulation.step();
  CHECK((simulation.report().needles[0].tip_force - force).norm() < 1e-3 * force.norm());
  CHECK(std::abs(simulation.report().needles[0].tip_position.z() - sunk_in) < 1e-6);
}

TEST_CASE("tissue with a window that lies against a needle begins with the force that it keeps") {
  Scene scene = standing_block();
  scene.gravity = {0, 0, 9.81};
  scene.tissue.regions[0].interaction.puncture_force = 5;
  scene.tissue.window = 8;
  scene.needles[0] = needle_at({0.004, 0.006, kHeight / 2}, 1e-3);
  Simulation simulation(scene);
  CHECK(goes_on_from_snapshot(simulation));
  std::vector<double> forces;
  for (int tick = 0; tick < 1000; ++tick) {
    simulation.step();
    forces.push_back(simulation.report().needles[0].tip_force.z());
  }
  for (const double force : forces) CHECK(force == doctest::Approx(forces.back()).epsilon(0.1).scale(0));  // 8 %
}

TEST_CASE("a needle that is placed elsewhere hangs there as its weight bends it") {
  Scene scene = standing_block();
  scene.needles[0].length = 0.2;
  scene.needles[0].outer_diameter = 0.5e-3;
  scene.needles[0].base = {{-0.2, 0, 0.3}, Quaternion(Eigen::AngleAxisd(0.3, Vector3::UnitY()))};
  const Simulation there(scene);
  const Pose elsewhere{{-0.1, 0.02, 0.2}, Quaternion(Eigen::AngleAxisd(-0.2, Vector3(0.3, 1, 0.2).normalized()))};
  const State placed = start_state(there.model(), there.state(), {{0, elsewhere}});
  scene.needles[0].base = elsewhere;
  const Simulation here(scene);
  CHECK(largest_move(placed.needles[0].x, here.state().needles[0].x) < 1e-10);
  CHECK(largest_move(placed.tissue.x, here.state().tissue.x) == 0);
  CHECK(largest_move(make_needle_state(here.model().needles[0], elsewhere).x, placed.needles[0].x) > 1e-3);
}

TEST_CASE("a reset goes back to the equilibrium, and needles are placed against it") {
  const Scene scene = standing_block();
  Simulation other(scene);
  const std::uint64_t start = hash(other.state());
  CHECK(goes_on_from_snapshot(other));
  CHECK(other.energy().potential == 0);
  other.command(0, {1, Pose{scene.needles[0].base.position - Vector3(0, 0, 0.02), scene.needles[0].base.orientation}, {}});
  for (int tick = 0; tick < 100; ++tick) other.step();
  CHECK(hash(other.state()) != start);
  other.reset();
  CHECK(hash(other.state()) == start);

  State placed = other.state();
  const Pose base = scene.needles[0].base;
  const auto lowered = [&](double by) { return Pose{base.position - Vector3(0, 0, by), base.orientation}; };
  const double above = 5e-3, surface = sunk(other, kHeight / 2);
  CHECK(surface > 2e-3);
  CHECK_NOTHROW(place_body(other.model(), placed, 0, lowered(above + 0.7 * surface)));
  CHECK_THROWS_AS(place_body(other.model(), placed, 0, lowered(above + 1.5 * surface)), PlacementError);
}

TEST_CASE("a start in equilibrium is refused where there is none") {
  Scene scene = standing_block();
  scene.tissue.fixed.clear();
  CHECK(refusal(scene).find("start: expected tissue that is held, found no fixed node") != std::string::npos);
  scene.gravity.setZero();
  CHECK(refusal(scene) == "");
  scene = standing_block();
  scene.tissue.box.cells = {3, 3, 3};
  scene.tissue.regions[0].material.young_modulus = 100;
  CHECK(refusal(scene).find("start: expected a static equilibrium, found elements") != std::string::npos);
  scene = standing_block();
  scene.gravity = {0, 0, 9.81};
  scene.tissue.regions[0].interaction.puncture_force = 0.01;
  scene.needles[0] = needle_at({0.004, 0.006, kHeight / 2}, 1e-3);
  CHECK(refusal(scene).find("needles[0].base: expected the needle's tip outside the tissue in equilibrium") !=
        std::string::npos);
  scene = standing_block();
  scene.tissue.pressures = {on_top(100)};
  scene.tissue.pressures[0].half_space->point.z() = 0.5;
  CHECK(refusal(scene).find("tissue.pressures[0]: expected a volume that holds faces") != std::string::npos);
}

}  // namespace acus::test
