// SPDX-License-Identifier: GPL-3.0-or-later
// What a hand feels at 1 kHz: nothing but a needle that goes in, through or out makes its base force jump, and no
// contact.
#include <doctest/doctest.h>

#include <algorithm>
#include <span>

#include "server/engine/math/random.h"
#include "tests/study/studies/force_jumps.h"
#include "tests/support/scenes.h"
#include "tests/validation/scene_run.h"

namespace acus::test {
namespace {

constexpr double kRate = 1000;       // Hz
constexpr double kLeastFelt = 0.05;  // N

SceneRun run_at_device_rate(const SceneWithTrajectory& scene) {
  return SceneRun(scene.scene, scene.trajectory, [](Scene& s, client::Trajectory&) { s.rate = kRate; });
}

// Returns the largest (N).
double check_ticks(std::span<const TickReport> ticks, std::size_t needles) {
  double largest = 0;
  for (int i = 0; i < static_cast<int>(needles); ++i) {
    CAPTURE(i);
    const double jump = largest_unexplained(ticks, i).size;
    CHECK(jump < kLeastFelt);
    largest = std::max(largest, jump);
  }
  return largest;
}

void check_scenes(std::size_t from, std::size_t to) {
  for (const SceneWithTrajectory& scene : std::span(kScenes).subspan(from, to - from)) {
    CAPTURE(scene.scene);
    SceneRun run = run_at_device_rate(scene);
    run.run();
    const double largest = check_ticks(run.ticks(), run.scene().needles.size());
    MESSAGE(std::string(scene.scene), ": ", largest, " N");
  }
}

// Stops all bases at random moments of a scene's motion and watches what the forces do from the next tick on: in the first
// one what moved against viscosity does so no more.
void check_holds(const SceneWithTrajectory& scene, int holds, unsigned seed) {
  constexpr int kHeld = 300;  // ticks
  Random random(seed);
  std::vector<double> times;
  const double end = fast_trajectory(scene.trajectory, 1).end();
  for (int i = 0; i < holds; ++i) times.push_back(random.uniform(0, end));
  std::ranges::sort(times);
  SceneRun run = run_at_device_rate(scene);
  Simulation held(run.scene());
  for (const double time : times) {
    CAPTURE(time);
    run.run_until(time);
    if (run.ticks().empty()) continue;
    held.restore(run.simulation().state());
    std::vector<TickReport> ticks;
    for (int i = 0; i < kHeld; ++i) {
      held.step();
      ticks.push_back(held.report());
    }
    check_ticks(ticks, run.scene().needles.size());
  }
}

constexpr std::size_t kAll = std::size(kScenes);

}  // namespace

TEST_CASE("a force jumps where something happens, and nowhere else: scenes, first third" *
          doctest::test_suite("full")) {
  check_scenes(0, 5);
}
TEST_CASE("a force jumps where something happens, and nowhere else: scenes, second third" *
          doctest::test_suite("full")) {
  check_scenes(5, 9);
}
TEST_CASE("a force jumps where something happens, and nowhere else: scenes, last third" * doctest::test_suite("full")) {
  check_scenes(9, kAll);
}

TEST_CASE("bases that stop at any moment feel forces that settle without a jump" * doctest::test_suite("full")) {
  unsigned seed = 0;
  for (const SceneWithTrajectory& scene : kScenes) {
    CAPTURE(scene.scene);
    check_holds(scene, 3, ++seed);
  }
}

TEST_CASE("a step is a jump, a ramp and a bend are none") {
  const auto at = [](double x) { return Vector3(x, 0, 0); };
  CHECK(force_jumps({}).empty());
  CHECK(force_jumps({at(1)}) == std::vector<double>{0.0});
  std::vector<Vector3> step(10, at(0)), bend(10, at(0)), spike(10, at(0));
  for (int i = 5; i < 10; ++i) step[i] = at(0.3), bend[i] = at(0.1 * (i - 4));
  spike[5] = at(0.2);
  const auto largest = [](const std::vector<Vector3>& forces) { return std::ranges::max(force_jumps(forces)); };
  CHECK(largest(step) == doctest::Approx(0.3));
  CHECK(largest(bend) < 1e-12);
  CHECK(largest(spike) > 0.19);
}

}  // namespace acus::test
