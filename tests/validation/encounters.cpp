// SPDX-License-Identifier: GPL-3.0-or-later
// Ways in and out other than the straight one through the middle of a face.
#include <doctest/doctest.h>

#include <limits>
#include <numbers>

#include "server/engine/math/rotation.h"
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
  CHECK(insertion.last().report.needles[0].inserted_depth < 0.1003);
  insertion.run({{-0.005, 0.06}});
  CHECK(insertion.find(EventKind::withdrawal) != nullptr);
  insertion.idle(2);
  CHECK((insertion.simulation().tissue_positions() - insertion.simulation().mesh().nodes).cwiseAbs().maxCoeff() < 2e-7);
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
  constexpr double kApart = 0.02, kTop = 0.05;  // m
  const Scene one = coarse_scene();
  Scene two = one;
  two.needles.push_back(two.needles[0]);
  two.needles[1].name = "second";
  two.needles[1].base.position.x() += kApart;
  Simulation alone(one), both(two);
  const Vector3 axis = one.needles[0].base.orientation * Vector3::UnitX();
  double touched = kInfinity;  // m, z where the second tip meets the surface
  std::uint32_t flags = 0;
  const auto run = [&](int ticks, double first_from, double first_step, double second_step) {
    for (int tick = 1; tick <= ticks; ++tick) {
      Command command{.seq = both.report().tick + 1, .pose = two.needles[1].base, .spin = {}};
      command.pose->position += second_step * tick * axis;
      both.command(1, command);
      command.pose->position = one.needles[0].base.position + (first_from + first_step * tick) * axis;
      both.command(0, command);
      alone.command(0, command);
      both.step();
      alone.step();
      flags |= both.report().flags | alone.report().flags;
      for (const Event& e : both.report().events)
        if (e.needle == 1 && e.kind == EventKind::contact) touched = e.position.z();
    }
  };
  const auto resistance = [&](const Simulation& s) { return -s.report().needles[0].base_force.dot(axis); };

  run(300, 0, 1e-4, 0);
  run(200, 0.03, 0, 0);
  const double held = resistance(alone);
  CHECK(resistance(both) == doctest::Approx(held).epsilon(1e-9).scale(0));

  run(500, 0.03, 0, 6e-5);
  for (const NeedleReport& n : both.report().needles) CHECK(n.phase == Phase::inside);
  const Material& m = one.tissue.regions[0].material;
  const double surface_sinks =  // of a half-space beside a force on it: Johnson, Contact Mechanics (1985), eq. 3.22
      held * (1 - m.poisson_ratio * m.poisson_ratio) / (std::numbers::pi * m.young_modulus * kApart);
  const double dent = kTop - touched;
  const double lost = resistance(alone) - resistance(both);
  MESSAGE("dent ", 1e3 * dent, " mm, of a half-space ", 1e3 * surface_sinks, " mm; the first, held by ", held,
          " N, loses ", lost, " N to the second");
  CHECK(dent == doctest::Approx(surface_sinks).epsilon(0.3).scale(0));
  CHECK(lost > 0.15 * held);
  CHECK(lost < 0.4 * held);
  CHECK(flags == 0);
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
