// SPDX-License-Identifier: GPL-3.0-or-later
// Nothing that a simulation computes depends on the registers of the processor.
#include <doctest/doctest.h>

#include "server/engine/state/bytes/report_hash.h"
#include "server/engine/state/bytes/state_bytes.h"
#include "tests/golden/trace_hash.h"
#include "tests/study/bench/trajectory_driver.h"
#include "tests/support/kernel_sets.h"
#include "tests/support/scenes.h"

namespace acus::test {

TEST_CASE("every scene gives the same reports and states with the kernels of both instruction sets") {
  if (only_one_set()) return;
  for (const SceneWithTrajectory& experiment : kScenes) {
    CAPTURE(experiment.scene);
    const auto run = [&] {
      Simulation simulation(read_scene(scene_file(experiment.scene)));
      TrajectoryDriver driver(simulation, fast_trajectory(experiment.trajectory, 8));
      TraceHash hash;
      const std::uint64_t ticks = std::min<std::uint64_t>(driver.ticks(), 400);
      for (std::uint64_t i = 0; i < ticks; ++i) {
        driver.command();
        simulation.step();
        hash.add(simulation);
      }
      return hash.value();
    };
    const auto [narrow, wide] = with_both_sets(run);
    CHECK(narrow == wide);
  }
}

}  // namespace acus::test
