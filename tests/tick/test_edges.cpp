// SPDX-License-Identifier: GPL-3.0-or-later
// A tip at the edges of the tissue: what it presses on turns as it slides, and past them nothing holds it back.
#include <doctest/doctest.h>

#include <algorithm>
#include <numbers>
#include <vector>

#include "server/engine/math/rotation.h"
#include "tests/study/studies/force_jumps.h"
#include "tests/tick/bench.h"

namespace acus::test {
namespace {

constexpr double kTop = 0.03;  // m, of the block, its edge at x = kTop

// A blunt tip 1 mm above the block, 10 mm from its edge.
Scene edge_scene(NeedleRung rung, double friction) {
  Scene scene = block_scene();
  scene.tissue.fixed.clear();
  scene.tissue.fixed.emplace_back().half_space = HalfSpace{Vector3(0, 0, -kTop + 1e-4), Vector3::UnitZ()};
  Material& material = scene.tissue.regions[0].material;
  material.young_modulus = 10e3;
  material.rayleigh_stiffness = 1e-2;
  Interaction& law = scene.tissue.regions[0].interaction;
  law.puncture_force = 5;
  law.friction_contact = friction;
  scene.needles = {needle_at({0.02, 3e-3, kTop}, 1e-3)};
  scene.needles[0].rung = rung;
  return scene;
}

// From where the tip presses at rest.
struct Slid {
  double largest = 0;  // N, of the base
  double jump = 0;     // N, without an event before it
  std::vector<Vector3> forces;
};

Slid slide_off(Bench& bench, double deep) {
  Slid slid;
  std::vector<TickReport> ticks;
  bench.push(0, 1e-3 + deep, 0.02);
  bench.wait(0.2);
  bench.each_tick = [&] { ticks.push_back(bench.simulation().report()); };
  bench.move(0, Vector3::UnitX() * 0.016, 0.01);
  for (const TickReport& tick : ticks) slid.forces.push_back(tick.needles[0].base_force);
  for (const Vector3& force : slid.forces) slid.largest = std::max(slid.largest, force.norm());
  slid.jump = largest_unexplained(ticks, 0).size;
  return slid;
}

}  // namespace

TEST_CASE("a rigid tip that is led over an edge feels it turn away, and no jump") {
  Bench bench(edge_scene(NeedleRung::rigid, 0));
  const Slid slid = slide_off(bench, 3e-3);
  CHECK(slid.largest > 0.1);
  CHECK(slid.jump < 0.05 * slid.largest);
  CHECK(bench.events(EventKind::release).size() == 1);
  CHECK(slid.forces.back().norm() < 1e-3);
  // It is pressed aside before it comes free.
  CHECK(
      std::ranges::any_of(slid.forces, [&](const Vector3& f) { return f.x() > 0.2 * slid.largest && f.x() > f.z(); }));
}

TEST_CASE("a bent needle that springs off an edge tells a slip before its force falls") {
  for (const double friction : {0.0, 0.3}) {
    CAPTURE(friction);
    Bench bench(edge_scene(NeedleRung::flexible, friction));
    const Slid slid = slide_off(bench, 6e-3);
    CHECK(slid.largest > 0.2);
    CHECK(slid.jump < 0.1 * slid.largest);
    CHECK(bench.events(EventKind::slip).size() >= 1);
    CHECK(bench.events(EventKind::puncture).empty());
  }
}

TEST_CASE("a tip past an edge, drawn back along a needle that lies over it, does not hook into the side") {
  Scene scene = edge_scene(NeedleRung::rigid, 0);
  Needle& needle = scene.needles[0];
  const double tilt = 0.5;  // rad, the tip away from the block
  const Vector3 along(std::sin(tilt), 0, -std::cos(tilt));
  needle.base.orientation = rotation_between(Vector3::UnitX(), along);
  // Over the edge with 12 mm of the needle beyond it, 1 mm away from it.
  needle.base.position =
      Vector3(kTop, 3e-3, kTop) + 1e-3 * Vector3(std::cos(tilt), 0, std::sin(tilt)) - (needle.length - 12e-3) * along;
  Bench bench(scene);
  bench.move(0, -2e-3 * Vector3(std::cos(tilt), 0, std::sin(tilt)), 0.01);
  bench.push(0, -1e-3, 0.02);  // past the force that starts it
  double pulls = 0, across = 0;
  bench.each_tick = [&] {
    pulls = std::max(pulls, bench.needle().base_force.dot(along));
    across = std::max(across, bench.needle().base_force.norm());
  };
  bench.push(0, -0.019, 0.02);
  CHECK(across > 0.01);
  CHECK(pulls < 0.05 * across);
  CHECK(bench.events(EventKind::puncture).empty());
  CHECK(bench.events(EventKind::intrusion).empty());
  CHECK(bench.needle().base_force.norm() < 1e-3);
}

}  // namespace acus::test
