// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/study/bench/trajectory_driver.h"

#include <doctest/doctest.h>

#include "tests/benchmarks/small_scene.h"

namespace acus {
namespace {

TEST_CASE("the driver plays a trajectory tick by tick, its first pose in the first tick") {
  Scene scene = test::small_scene();
  scene.needles[0].smoothing = 0;
  Simulation simulation(scene);
  TrajectoryDriver driver(simulation, test::small_push());
  REQUIRE(driver.ticks() == 126);
  for (std::uint64_t tick = 0; tick < driver.ticks(); ++tick) {
    driver.command();
    simulation.step();
    const NeedleReport& needle = simulation.report().needles[0];
    CHECK(needle.command_seq == tick + 1);
    CHECK(needle.base.position.z() == doctest::Approx(0.132 - 0.000096 * static_cast<double>(tick)));
  }
}

TEST_CASE("a time of the trajectory takes the ticks that begin up to it") {
  Simulation simulation(test::small_scene());
  const TrajectoryDriver driver(simulation, test::small_push());
  CHECK(driver.ticks_until(1.0) == 1);
  CHECK(driver.ticks_until(2.0) == 1);
  CHECK(driver.ticks_until(2.0625) == 64);
  CHECK(driver.ticks_until(2.09375) == 95);
}

TEST_CASE("a motion of something that the scene has not is an error that names both") {
  Simulation simulation(test::small_scene());
  client::Trajectory trajectory = test::small_push();
  trajectory.motions[0].needle = "probe";
  CHECK_THROWS_WITH_AS(TrajectoryDriver(simulation, trajectory),
                       "the trajectory moves 'probe', but scene 'small' has no needle or guide of that name",
                       std::runtime_error);
}

}  // namespace
}  // namespace acus
