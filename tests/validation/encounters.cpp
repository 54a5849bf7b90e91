// SPDX-License-Identifier: GPL-3.0-or-later
// Ways in and out other than the straight one through the middle of a face.
#include <doctest/doctest.h>

#include <limits>
#include <numbers>

#include "server/math/rotation.h"
#include "tests/validation/insertion_run.h"

namespace acus::test {

namespace {

Scene small_scene() {
  Scene scene = coarse_scene();
  scene.tissue.box.cells = {4, 4, 4};
  return scene;
}

// The needle with its tip `above` the point `at` of the top face (z = 0.05), tilted from the vertical about y.
Pose aimed_at(const Scene& scene, const Vector3& at, double above, double tilt) {
  const Quaternion down = rotation_exp({0, std::numbers::pi / 2 + tilt, 0});
  const Vector3 axis = down * Vector3::UnitX();
  return {at - (above + scene.needles[0].length) * axis, down};
}

}  // namespace

TEST_CASE("a tilted needle punctures") {
  for (const double degrees : {0.0, 15.0, 30.0}) {
    Scene scene = small_scene();
    scene.needles[0].outer_diameter = 2e-3;  // a thin one would bend away
    scene.needles[0].base = aimed_at(scene, {0.003, 0.002, 0.05}, 0.005, degrees * std::numbers::pi / 180);
    InsertionRun insertion(scene);
    insertion.run({{0.03, 0.05}});
    CAPTURE(degrees);
    CHECK(insertion.find(EventKind::puncture) != nullptr);
    CHECK(insertion.last().report.needles[0].phase == Phase::inside);
  }
}

TEST_CASE("a face is flat up to its edge") {
  Scene scene = small_scene();
  scene.needles[0].base = aimed_at(scene, {0.046, 0.003, 0.05}, 0.005, 0);
  InsertionRun insertion(scene);
  insertion.run({{0.03, 0.05}});
  CHECK(insertion.find(EventKind::puncture) != nullptr);
}

TEST_CASE("out on the far side and back again") {
  Scene scene = small_scene();
  scene.tissue.fixed = {Volume{}};
  scene.tissue.fixed[0].box = Box{{-kInfinity, -kInfinity, -kInfinity}, {-0.05, kInfinity, kInfinity}};
  InsertionRun insertion(scene);
  insertion.run({{0.125, 0.06}});
  const Event* exit = insertion.find(EventKind::exit);
  REQUIRE(exit != nullptr);
  CHECK(exit->position.z() < -0.045);
  CHECK(insertion.last().report.needles[0].phase == Phase::through);
  CHECK(insertion.last().report.needles[0].inserted_depth < 0.105);
  insertion.run({{-0.005, 0.06}});
  CHECK(insertion.find(EventKind::withdrawal) != nullptr);
  insertion.idle(2);
  CHECK((insertion.simulation().tissue_positions() - insertion.simulation().mesh().nodes).cwiseAbs().maxCoeff() < 1e-6);
}

TEST_CASE("an old mouth is entered without a puncture") {
  InsertionRun insertion(small_scene());
  insertion.run({{0.04, 0.05}, {-0.002, 0.05, 0.3}, {0.035, 0.05}});
  CHECK(insertion.find(EventKind::withdrawal) != nullptr);
  CHECK(insertion.find(EventKind::reentry) != nullptr);
  int punctures = 0;
  for (const Sample& s : insertion.samples())
    for (const Event& e : s.report.events) punctures += e.kind == EventKind::puncture ? 1 : 0;
  CHECK(punctures == 1);
  CHECK(insertion.last().report.needles[0].cutting_force.norm() < 1e-9);
}

TEST_CASE("bone is never entered") {
  Scene scene = small_scene();
  scene.tissue.regions[0].interaction.puncture_force = kInfinity;
  scene.needles[0].outer_diameter = 3e-3;
  InsertionRun insertion(scene);
  insertion.run({{0.025, 0.05}});
  CHECK(insertion.find(EventKind::contact) != nullptr);
  CHECK(insertion.find(EventKind::puncture) == nullptr);
  CHECK(insertion.last().resistance > 1.5);
}

TEST_CASE("two needles share one tissue") {
  Scene scene = small_scene();
  scene.needles.push_back(scene.needles[0]);
  scene.needles[1].name = "second";
  scene.needles[1].base.position += Vector3(0.01, 0, 0);
  Simulation simulation(scene);
  const Vector3 axis = scene.needles[0].base.orientation * Vector3::UnitX();
  for (int tick = 1; tick <= 500; ++tick) {
    for (int i = 0; i < 2; ++i) {
      Command command{.seq = static_cast<std::uint64_t>(tick), .pose = scene.needles[i].base, .spin = {}};
      command.pose->position += 1e-4 * tick * axis;
      simulation.command(i, command);
    }
    simulation.step();
  }
  for (int i = 0; i < 2; ++i) {
    CHECK(simulation.report().needles[i].phase == Phase::inside);
    CHECK(simulation.report().needles[i].base_force.norm() > 0.5);
  }
  // The second pushes on through the first one's dent, which it shares.
  CHECK((simulation.report().flags & ~std::uint32_t{kLawsNotConverged}) == 0);
}

TEST_CASE("a tip that starts inside is refused") {
  Scene scene = small_scene();
  scene.needles[0].base.position.z() -= 0.03;
  CHECK_THROWS_WITH_AS(Simulation{scene}, doctest::Contains("needles[0].base"), SceneError);
}

TEST_CASE("a tissue without a free node is refused") {
  Scene scene = small_scene();
  scene.tissue.fixed = {Volume{}};
  scene.tissue.fixed[0].box = Box{};
  CHECK_THROWS_WITH_AS(Simulation{scene}, doctest::Contains("tissue.fixed"), SceneError);
}

TEST_CASE("a command that is no number, or beyond the workspace, changes nothing") {
  const Scene scene = small_scene();
  Simulation quiet(scene), disturbed(scene);
  Command good{.seq = 1, .pose = scene.needles[0].base, .spin = {}};
  good.pose->position.x() += 1e-3;
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), 1e308, -2 * kMaxPosition}) {
    Command broken = good;
    broken.seq = 2;
    broken.pose->position.x() = bad;
    CHECK(quiet.command(0, good));
    CHECK(disturbed.command(0, good));
    CHECK_FALSE(disturbed.command(0, broken));
    quiet.step();
    disturbed.step();
    CHECK_FALSE(disturbed.command(0, broken));
    CHECK(disturbed.report().flags == quiet.report().flags);
    CHECK((disturbed.report().flags & kNotFinite) == 0);
    CHECK(disturbed.report().needles[0].command_seq == 1);
    CHECK(disturbed.needle_positions(0) == quiet.needle_positions(0));
    CHECK(disturbed.tissue_positions() == quiet.tissue_positions());
  }
}

}  // namespace acus::test
