// SPDX-License-Identifier: GPL-3.0-or-later
// The force at the base against the laws themselves: in a steady straight insertion the tissue can only push back with
// the cutting force and the sliding friction of the inserted length, whatever the discretisation.
#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

#include "tests/validation/insertion_run.h"

namespace acus::test {
namespace {

constexpr double kSpeed = 0.01;  // m/s

double friction_per_metre(const Scene& scene) {
  const Region& region = scene.tissue.regions[0];
  return std::numbers::pi * scene.needles[0].outer_diameter * region.interaction.friction_dynamic *
         shaft_pressure(region);
}

double expected_force(const Scene& scene, double inserted, double speed) {
  const Interaction& law = scene.tissue.regions[0].interaction;
  return law.cutting_force + (friction_per_metre(scene) + law.friction_viscous * speed) * inserted;
}

// Largest relative departure from the expected force between 15 mm and 35 mm of depth.
double steady_error(const Scene& scene) {
  InsertionRun insertion(scene);
  insertion.run({{0.055, kSpeed}});
  double worst = 0;
  int compared = 0;
  for (const Sample& s : insertion.samples()) {
    const double depth = s.report.needles[0].inserted_depth;
    if (s.report.needles[0].phase != Phase::inside || depth < 0.015 || depth > 0.035) continue;
    const double expected = expected_force(scene, depth, kSpeed);
    worst = std::max(worst, std::abs(s.resistance - expected) / expected);
    ++compared;
  }
  CHECK(compared > 100);
  return worst;
}

Scene slow_scene() {
  Scene scene = default_scene();
  scene.tissue.regions[0].interaction.friction_viscous = 0;
  return scene;
}

}  // namespace

TEST_CASE("a steady insertion meets cutting force and sliding friction") {
  const double error = steady_error(slow_scene());
  MESSAGE("largest departure: " << 100 * error << " %");
  CHECK(error < 4e-4);
}

TEST_CASE("viscous friction adds its share per length and speed") {
  Scene scene = default_scene();
  REQUIRE(scene.tissue.regions[0].interaction.friction_viscous > 0);
  CHECK(steady_error(scene) < 5e-3);
}

TEST_CASE("the force of a steady insertion does not depend on the time step" * doctest::test_suite("full")) {
  for (const double rate : {1000.0, 500.0, 200.0}) {
    Scene scene = slow_scene();
    scene.rate = rate;
    CAPTURE(rate);
    CHECK(steady_error(scene) < 5e-4);
  }
}

TEST_CASE("the force of a steady insertion does not depend on the solver's tolerance") {
  for (const double tolerance : {1e-4, 1e-9}) {
    Scene scene = slow_scene();
    scene.laws.tolerance = tolerance;
    scene.laws.max_steps = 10000;
    CAPTURE(tolerance);
    CHECK(steady_error(scene) < 4e-4);
  }
}

TEST_CASE("the force of a steady insertion does not depend on the constraint spacing" * doctest::test_suite("full")) {
  for (const double spacing : {0.002, 0.004, 0.008}) {
    Scene scene = slow_scene();
    scene.needles[0].constraint_spacing = spacing;
    CAPTURE(spacing);
    CHECK(steady_error(scene) < 6e-4);
  }
}

TEST_CASE("the surface gives way at the puncture force") {
  const Scene scene = default_scene();
  const double f_p = scene.tissue.regions[0].interaction.puncture_force;
  InsertionRun insertion(scene);
  double peak = 0;
  insertion.run({{0.03, kSpeed / 2}}, [&](const Sample& s) {
    if (s.report.needles[0].phase != Phase::inside) peak = std::max(peak, s.resistance);
  });
  const Event* puncture = insertion.find(EventKind::puncture);
  REQUIRE(puncture != nullptr);
  CHECK(puncture->force == doctest::Approx(f_p).epsilon(1e-6));
  // At the base, where a hand would feel it.
  CHECK(std::abs(peak - f_p) < 3e-3 * f_p);
}

TEST_CASE("an old path costs no cutting force, its end does") {
  Scene scene = slow_scene();
  const double f_c = scene.tissue.regions[0].interaction.cutting_force;
  InsertionRun insertion(scene);
  // In to about 38 mm, back to about 17 mm, and in again past the old end.
  insertion.run({{0.05, 0.02}, {0.025, 0.02}, {0.06, 0.02}});

  // The force at a given depth, first insertion (way = 0) and second (way = 1).
  const auto force_at = [&](double depth, int way) {
    double before = 0, force = 0;
    int crossings = 0;
    for (const Sample& s : insertion.samples()) {
      const double now = s.report.needles[0].inserted_depth;
      if (before < depth && now >= depth && crossings++ == way) force = s.resistance;
      before = now;
    }
    CHECK(crossings > way);
    return force;
  };
  for (const double depth : {0.025, 0.028, 0.030}) {
    CAPTURE(depth);
    CHECK(std::abs(force_at(depth, 0) - force_at(depth, 1) - f_c) < 1e-2 * f_c);
  }
  CHECK(insertion.last().resistance > 0);
  const double deepest = insertion.last().report.needles[0].inserted_depth;
  CHECK(insertion.last().report.needles[0].cutting_force.norm() == doctest::Approx(f_c).epsilon(1e-3));
  CHECK(deepest > 0.045);
}

TEST_CASE("reversal turns the friction round") {
  const Scene scene = slow_scene();
  const double per_metre = friction_per_metre(scene);
  InsertionRun insertion(scene);
  insertion.run({{0.05, 0.02}, {0.03, 0.02}});
  const NeedleReport& pulled = insertion.last().report.needles[0];
  // Held back by the whole sliding friction and by nothing else. The last leg ends in a stop, so look at the middle.
  int checked = 0;
  for (const Sample& s : insertion.samples()) {
    if (s.commanded > 0.040 || s.commanded < 0.034 || s.time < 3) continue;
    const double expected = -per_metre * s.report.needles[0].inserted_depth;
    CHECK(std::abs(s.resistance - expected) < 3e-4 * std::abs(expected));
    CHECK(s.report.needles[0].cutting_force.norm() < 1e-9);
    ++checked;
  }
  CHECK(checked > 100);
  CHECK(pulled.phase == Phase::inside);
}

TEST_CASE("no tick jumps but the puncture's") {
  // Points enter and leave, elements are crossed, the direction turns, the old end is met again: friction and lateral
  // forces move smoothly through all of it. The cutting force does not belong here: when the tip meets the old end at
  // speed, the tissue's viscosity takes part of f_c up at once.
  const Scene scene = default_scene();
  InsertionRun insertion(scene);
  insertion.run({{0.06, 0.02, 0.3}, {0.035, 0.02, 0.3}, {0.075, 0.02, 0.3}, {0.0, 0.03}});
  double friction_before = 0, lateral_before = 0, largest_friction = 0, largest_lateral = 0;
  int since_puncture = 1000;
  for (const Sample& s : insertion.samples()) {
    for (const Event& e : s.report.events)
      if (e.kind == EventKind::puncture) since_puncture = 0;
    const NeedleReport& n = s.report.needles[0];
    const double friction = n.friction_force.dot(n.base.orientation * Vector3::UnitX());
    const double lateral = n.lateral_force.norm();
    if (since_puncture++ > 3) {
      largest_friction = std::max(largest_friction, std::abs(friction - friction_before));
      largest_lateral = std::max(largest_lateral, std::abs(lateral - lateral_before));
    }
    if (n.phase == Phase::inside && since_puncture > 1)  // in the tick of the puncture the force is f_p
      CHECK(n.cutting_force.norm() <= scene.tissue.regions[0].interaction.cutting_force * (1 + 1e-9));
    friction_before = friction;
    lateral_before = lateral;
  }
  MESSAGE("largest steps: friction " << largest_friction << " N, lateral " << largest_lateral << " N");
  CHECK(largest_friction < 0.06);
  CHECK(largest_lateral < 3e-3);
  CHECK(insertion.find(EventKind::withdrawal) != nullptr);
}

}  // namespace acus::test
