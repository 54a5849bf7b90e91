// SPDX-License-Identifier: GPL-3.0-or-later
// Outcomes of the scenes in which a needle goes straight through layers: what it feels in each, and the events.
#include <doctest/doctest.h>

#include <numbers>

#include "tests/validation/scene_run.h"

namespace acus::test {
namespace {

std::size_t tick_at(const SceneRun& run, double time) {
  return static_cast<std::size_t>(std::lround(time * run.scene().rate)) - 1;
}

double largest_displacement(const Simulation& simulation) {
  return (simulation.tissue_positions() - simulation.mesh().nodes).cwiseAbs().maxCoeff();
}

// Length (m) of the shaft above and below a level of the rest shape, along path 0 from its mouth in the mesh to the
// needle's tip, which is beyond the path's end by what the tissue ahead of it yields; scaled to the inserted length,
// which counts from where the skin really is (owned_lengths.h).
struct Lengths {
  double above = 0, below = 0;
};

Lengths lengths_beside(const Simulation& simulation, double level, double inserted) {
  Matrix3X path(3, simulation.path_capacity());
  const int points = simulation.path_positions(0, path);
  const Vector3 tip = simulation.report().needles[0].tip_position;
  const Vector3 along = simulation.report().needles[0].base.orientation * Vector3::UnitX();
  Lengths lengths;
  for (int i = 0; i + 1 < points; ++i) {
    const Vector3 from = path.col(i), to = path.col(i + 1);
    const double piece = std::clamp(along.dot(tip - from), 0.0, (to - from).norm());
    const double z_from = rest_position(simulation, from).z(), z_to = rest_position(simulation, to).z();
    const double share = std::clamp((z_from - level) / std::max(z_from - z_to, 1e-9), 0.0, 1.0);
    lengths.above += share * piece;
    lengths.below += (1 - share) * piece;
  }
  const double beyond = std::max(0.0, along.dot(tip - path.col(points - 1)));
  (rest_position(simulation, path.col(points - 1)).z() > level ? lengths.above : lengths.below) += beyond;
  const double scale = inserted / (lengths.above + lengths.below);
  return {scale * lengths.above, scale * lengths.below};
}

// Friction of a shaft that slides at a speed (N/m).
double friction_per_metre(const Region& region, double diameter, double speed) {
  return std::numbers::pi * diameter * region.interaction.friction_dynamic * shaft_pressure(region) +
         region.interaction.friction_viscous * speed;
}

// The base's force at the moment of an event, over the last ticks before it, less what it is a while later.
double drop_after(const SceneRun& run, const Event& event, double later) {
  const auto at = static_cast<std::size_t>(event.tick) - 1;
  double peak = 0;
  for (std::size_t i = at - 10; i <= at; ++i) peak = std::max(peak, run.resistance(i));
  return peak - run.resistance(at + static_cast<std::size_t>(later * run.scene().rate));
}

}  // namespace

TEST_CASE("insertion_pullback_layers: each layer has its own plateau") {
  // The needle takes the skin along and is out late in the motion: a moment more for the tissue to come to rest.
  SceneRun run("insertion_pullback_layers", "insertion_pullback", [](Scene&, client::Trajectory& motion) {
    std::vector<client::Sample>& samples = motion.motions[0].samples;
    samples.push_back({samples.back().time + 0.2, samples.back().pose});
  });
  const Region& lower = run.scene().tissue.regions[0];
  const Region& upper = run.scene().tissue.regions[1];
  const double diameter = run.scene().needles[0].outer_diameter;
  constexpr double kSpeed = 0.02, kLevel = 0.1 / 6;  // m/s of the trajectory, m
  struct Moment {
    double time;     // s, in the middle of a move
    int way;         // 1 in, -1 out
    double cutting;  // N
  };
  const double f_upper = upper.interaction.cutting_force, f_lower = lower.interaction.cutting_force;
  const Moment moments[] = {{2.0, 1, f_upper},  {2.5, 1, f_upper}, {3.5, 1, f_lower}, {4.0, 1, f_lower},
                            {6.2, -1, 0},       {6.8, -1, 0},      {8.7, 1, 0},       {9.6, 1, f_lower},
                            {10.0, 1, f_lower}, {12.2, -1, 0},     {13.2, -1, 0},     {14.5, -1, 0}};
  for (const Moment& moment : moments) {
    run.run_until(moment.time);
    const std::size_t tick = run.ticks().size() - 1;
    const Lengths l = lengths_beside(run.simulation(), kLevel, run.needle(tick).inserted_depth);
    const double friction =
        friction_per_metre(upper, diameter, kSpeed) * l.above + friction_per_metre(lower, diameter, kSpeed) * l.below;
    const double expected = moment.cutting + moment.way * friction;
    CAPTURE(moment.time);
    CAPTURE(expected);
    // Of the shaft at the border a vertex's own length counts to one layer: up to half a spacing.
    CHECK(std::abs(run.resistance(tick) - expected) < 0.05 * std::abs(expected));
  }
  run.run();
  check_sound(run);
  CHECK(names(run.events(), run.scene()) ==
        "contact upper, puncture upper, contact lower, crossing lower, withdrawal upper");
  CHECK(run.find(EventKind::puncture)->force == doctest::Approx(upper.interaction.puncture_force).epsilon(1e-6));
  CHECK(run.find(EventKind::crossing)->force == doctest::Approx(1.2).epsilon(1e-6));
  CHECK(largest_displacement(run.simulation()) < 7e-9);
}

TEST_CASE("layers: one event and one drop of the force at each layer") {
  SceneRun run("layers");
  run.run();
  check_sound(run);
  CHECK(names(run.events(), run.scene()) ==
        "contact skin, puncture skin, contact fat, crossing fat, contact muscle, crossing muscle, withdrawal skin");
  int checked = 0;
  for (const Event& event : run.events()) {
    if (event.kind != EventKind::puncture && event.kind != EventKind::crossing) continue;
    const Interaction& into = run.scene().tissue.regions[static_cast<std::size_t>(event.region)].interaction;
    CAPTURE(run.scene().tissue.regions[static_cast<std::size_t>(event.region)].name);
    CHECK(event.force == doctest::Approx(into.puncture_force).epsilon(1e-6));
    // While the tip is held, part of the shaft sticks; the friction that comes back hides some of the drop.
    CHECK(drop_after(run, event, 0.05) > 0.7 * (into.puncture_force - into.cutting_force));
    ++checked;
  }
  CHECK(checked == 3);
  CHECK(largest_displacement(run.simulation()) < 1e-9);
}

TEST_CASE("through: out on the far side, back in, and the tissue at rest") {
  SceneRun run("through");
  run.run();
  check_sound(run);
  CHECK(names(run.events(), run.scene()) == "contact slab, puncture slab, exit slab, reentry slab, withdrawal slab");
  const Event* exit = run.find(EventKind::exit);
  REQUIRE(exit != nullptr);
  CHECK(exit->force == doctest::Approx(run.scene().tissue.regions[0].interaction.cutting_force).epsilon(1e-6));
  CHECK(exit->position.z() < -0.015);
  CHECK(run.needle(tick_at(run, 3.5)).phase == Phase::through);
  CHECK(run.needle(tick_at(run, 3.5)).inserted_depth == doctest::Approx(0.03).epsilon(6e-4).scale(0));
  CHECK(run.needle(tick_at(run, 3.5)).cutting_force.norm() == 0);
  CHECK(largest_displacement(run.simulation()) < 1e-9);
}

TEST_CASE("biopsy: at 100 mm/s the force jumps at the puncture, the contact and the lesion alone") {
  SceneRun run("biopsy");
  run.run();
  check_sound(run);
  CHECK(names(run.events(), run.scene()) == "contact breast, puncture breast, crossing lesion, withdrawal breast");
  CHECK(run.find(EventKind::puncture)->force == doctest::Approx(2).epsilon(1e-6));
  CHECK(run.find(EventKind::crossing)->force == doctest::Approx(1).epsilon(1e-6));
  // Ticks shortly after those events, in which the step of the law reaches the base, are left out. What is left is the
  // turn from in to out, 0.1 mm a tick against the stiffness and viscosity of the tissue.
  double largest = 0;
  std::size_t quiet = 0, largest_at = 0;
  for (std::size_t i = 1; i < run.ticks().size(); ++i) {
    quiet = run.ticks()[i].events.empty() ? quiet + 1 : 0;
    const double jump = std::abs(run.resistance(i) - run.resistance(i - 1));
    if (quiet > 20 && jump > largest) largest = jump, largest_at = i;
  }
  MESSAGE("largest jump " << largest << " N at tick " << largest_at);
  CHECK(largest < 0.15);
}

}  // namespace acus::test
