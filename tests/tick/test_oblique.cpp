// SPDX-License-Identifier: GPL-3.0-or-later
// Needles that come to a surface aslant, as in the spine or a vein.
#include <doctest/doctest.h>

#include <algorithm>
#include <numbers>
#include <optional>

#include "server/engine/math/rotation.h"
#include "server/engine/tick/simulation.h"

namespace acus {
namespace {

constexpr double kPunctureForce = 0.3;  // N
constexpr double kWay = 0.03;           // m, of the base

struct Entry {
  bool inside = false;
  double depth = 0;   // m
  double force = 0;   // N, as the event tells it
  double peak = 0;    // N, largest along the needle before,
  double slid = 0;    // m, of the tip across the normal before, from where it touched
};

// Pushes a needle towards the middle of a block's top, tilted from its normal, at 20 mm/s.
Entry push(TipShape tip, double degrees, double azimuth) {
  Scene scene;
  scene.rate = 250;
  scene.tissue.box = {{0.1, 0.1, 0.1}, {6, 6, 6}};
  scene.tissue.regions[0].material.young_modulus = 20e3;
  scene.tissue.regions[0].interaction.puncture_force = kPunctureForce;
  scene.tissue.regions[0].interaction.friction_contact = 0.3;
  Volume bottom;
  bottom.box = Box{Vector3::Constant(-kInfinity), {kInfinity, kInfinity, -0.049}};
  scene.tissue.fixed = {bottom};
  Needle& needle = scene.needles[0];
  needle.tip = tip;
  const Quaternion down = rotation_exp({0, std::numbers::pi / 2, 0});
  const Quaternion tilt = rotation_exp({0, -degrees * std::numbers::pi / 180, 0});
  needle.base.orientation = rotation_exp({0, 0, azimuth}) * tilt * down;
  const Vector3 along = needle.base.orientation * Vector3::UnitX();
  needle.base.position = Vector3(0.001, 0.002, 0.0505) - needle.length * along;
  Simulation simulation(scene);
  Entry entry;
  std::optional<Vector3> touched;
  for (int tick = 1; tick <= kWay / 0.02 * scene.rate; ++tick) {
    const Pose pose{needle.base.position + 0.02 / scene.rate * tick * along, needle.base.orientation};
    simulation.command(0, {.seq = 1, .pose = pose, .spin = {}});
    simulation.step();
    for (const Event& event : simulation.report().events)
      if (event.kind == EventKind::puncture) entry.force = event.force;
    const NeedleReport& report = simulation.report().needles[0];
    if (report.phase == Phase::contact && !touched) touched = report.tip_position;
    if (entry.force == 0) entry.peak = std::max(entry.peak, -report.tip_force.dot(along));
    if (entry.force == 0 && touched) entry.slid = (report.tip_position - *touched).head<2>().norm();
    entry.inside = report.phase == Phase::inside;
    entry.depth = report.inserted_depth;
  }
  return entry;
}

TEST_CASE("sharp tips go in at 15 to 75 degrees from the normal, when the force along the needle is f_p" *
          doctest::test_suite("gate")) {
  for (const TipShape tip : {TipShape::bevel, TipShape::pencil})
    for (const double degrees : {0.0, 15.0, 30.0, 45.0, 60.0, 72.0}) {
      CAPTURE(static_cast<int>(tip));
      CAPTURE(degrees);
      const Entry entry = push(tip, degrees, degrees);  // towards any side
      CHECK(entry.inside);
      CHECK(entry.depth > kWay / 3);
      CHECK(entry.force == doctest::Approx(kPunctureForce).epsilon(0.1));
      CHECK(entry.peak == doctest::Approx(kPunctureForce).epsilon(0.1));
    }
}

TEST_CASE("tips that do not bite slide on before they go in, if they do" * doctest::test_suite("gate")) {
  const Entry straight = push(TipShape::blunt, 0, 0);
  CHECK(straight.inside);
  CHECK(straight.slid < 1e-3);
  CHECK(push(TipShape::bevel, 45, 0.3).slid < 3e-3);
  CHECK(push(TipShape::blunt, 45, 0.3).slid > 6e-3);
  CHECK(push(TipShape::trocar, 75, 0.3).slid > 6e-3);
}

}  // namespace
}  // namespace acus
