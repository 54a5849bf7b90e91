// SPDX-License-Identifier: GPL-3.0-or-later
// What a simulation leaves out while it economises, and what it says about it.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "server/engine/tick/simulation.h"

namespace acus {
namespace {

constexpr std::uint32_t kCaps = kStepsCapped | kIterationsCapped;
constexpr int kTicks = 60;  // in, and as many back

// A needle 1 mm above a block, pointing down.
Scene scene_of(TissueRung rung) {
  Scene scene;
  scene.rate = 500;
  scene.gravity = {0, 0, -9.81};
  scene.tissue.rung = rung;
  scene.tissue.box.cells = {4, 4, 4};
  Volume bottom;
  bottom.box.emplace().max.z() = -0.05;
  scene.tissue.fixed.push_back(bottom);
  Needle& needle = scene.needles[0];
  needle.length = 0.1;
  needle.beams = 10;
  needle.constraint_spacing = 2e-3;
  needle.base = {Vector3(0.003, 0.002, 0.151), Quaternion(std::sqrt(0.5), 0, std::sqrt(0.5), 0)};
  scene.laws.solver = LawMethod::gauss_seidel;
  scene.laws.tolerance = 1e-11;
  return scene;
}

struct Run {
  std::uint32_t flags = 0;  // of any tick
  int sweeps = 0, iterations = 0;
  double largest_force = 0;     // N, at the base
  std::vector<Vector3> forces;  // N, at the base
};

// Pushes the needle 40 mm into the block and to the side, then draws it back by 0.3 mm, so that the shaft sticks.
Run run(const Scene& scene, bool economizing) {
  Simulation simulation(scene);
  simulation.economize(economizing);
  Run run;
  for (int i = 1; i <= 2 * kTicks; ++i) {
    Pose pose = scene.needles[0].base;
    pose.position += std::min(i, kTicks) * Vector3(0.002, 0, -0.04) / kTicks;
    pose.position.z() += std::max(i - kTicks, 0) * 3e-4 / kTicks;
    simulation.command(0, {static_cast<std::uint64_t>(i), pose, std::nullopt});
    simulation.step();
    const TickReport& report = simulation.report();
    run.flags |= report.flags;
    run.sweeps = std::max(run.sweeps, report.sweeps);
    run.iterations = std::max(run.iterations, report.newton_iterations);
    run.forces.push_back(report.needles[0].base_force);
    run.largest_force = std::max(run.largest_force, run.forces.back().norm());
  }
  return run;
}

}  // namespace

TEST_CASE("lower limits hold while the simulation economises only, and flags say which stopped it" *
          doctest::test_suite("gate")) {
  Scene scene = scene_of(TissueRung::exact);
  scene.overrun.max_steps = 1;
  scene.overrun.max_iterations = 1;
  const Run full = run(scene, false), less = run(scene, true);
  CHECK((full.flags & kCaps) == 0);
  CHECK(full.sweeps > 1);
  CHECK(full.iterations > 1);
  CHECK((less.flags & kCaps) == kCaps);
  CHECK(less.sweeps == 1);
  CHECK(less.iterations == 1);
}

TEST_CASE("a limit that is not reached leaves no mark: the same forces, bit by bit, and no flag" *
          doctest::test_suite("gate")) {
  Scene scene = scene_of(TissueRung::exact);
  scene.overrun.max_steps = scene.laws.max_steps;
  scene.overrun.max_iterations = scene.newton.max_iterations;
  const Run full = run(scene, false), less = run(scene, true);
  CHECK((less.flags & kCaps) == 0);
  CHECK(less.forces == full.forces);
}

TEST_CASE("with one sweep a tick the physics stays bounded, and comes to rest at nearly the same force") {
  Scene scene = scene_of(TissueRung::warped);
  scene.overrun.max_steps = 1;
  const Run full = run(scene, false), less = run(scene, true);
  CHECK((less.flags & kStepsCapped) != 0);
  CHECK((less.flags & kIterationsCapped) == 0);
  CHECK((less.flags & kNotFinite) == 0);
  CHECK(less.largest_force < 1.01 * full.largest_force);
  CHECK((less.forces.back() - full.forces.back()).norm() < 6e-3 * full.largest_force);
}

}  // namespace acus
