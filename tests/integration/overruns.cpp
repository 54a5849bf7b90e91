// SPDX-License-Identifier: GPL-3.0-or-later
// A scene that no machine keeps up with: a thousand nodes, refactorised up to twenty times a tick, a thousand times a
// second.
#include <doctest/doctest.h>

#include <cmath>

#include "tests/integration/server_process.h"

namespace acus::testing {
namespace {

constexpr std::uint32_t kCaps = protocol::kIterationsCapped | protocol::kStepsCapped | protocol::kPublishingReduced;

const char* const kHeavyScene = R"(acus_scene: 1
name: heavy
rate: 1000
tissue:
  rung: exact
  mesh:
    box: {size: [0.1, 0.1, 0.1], cells: [9, 9, 9]}
  fixed:
    - box: {max: [.inf, .inf, -0.05]}
needles:
  - length: 0.1
    beams: 10
    base: {position: [0.003, 0.002, 0.151], orientation: [0.7071068, 0, 0.7071068, 0]}
laws: {solver: gauss_seidel, tolerance: 1e-9}
overrun: {max_steps: 1, max_iterations: 1, publish_every: 1000}
publish: {needle_rate: 1000}
)";

// Deep into the tissue, sideways too, so that the laws have something to solve.
protocol::Pose inside(std::uint64_t seq) {
  protocol::Pose pose = pose_at(0.13, seq);
  pose.position[0] = 0.006;
  pose.orientation = {0.7071068, 0, 0.7071068, 0};
  return pose;
}

void check_bounded(const protocol::Force& force) {
  for (const protocol::Vector3& v : {force.base_force, force.base_torque, force.tip_force, force.cutting_force,
                                     force.friction_force, force.lateral_force}) {
    CHECK(std::hypot(v[0], v[1], v[2]) < 100);  // false for not-a-number
  }
  CHECK(std::hypot(force.tip_position[0], force.tip_position[1], force.tip_position[2]) < 0.3);
  CHECK((force.flags & protocol::kNotFinite) == 0);
}

}  // namespace

TEST_CASE("late ticks: the scene's policy takes effect, states say so, forces and answers keep coming" *
          doctest::test_suite("clock")) {
  ServerProcess server({}, kHeavyScene);
  client::CommandLink commands = hold(server);
  client::StateLink states = subscribe(server, {"force", "needle"});
  REQUIRE(commands.send(inside(1)));

  std::uint32_t seen = 0;
  std::uint64_t tick = receive<protocol::Force>(states).tick;
  for (int i = 0; i < 500 && (seen & kCaps) != kCaps; ++i) {
    const auto force = receive<protocol::Force>(states);
    CHECK(force.tick == ++tick);
    check_bounded(force);
    seen |= force.flags;
  }
  CHECK((seen & kCaps) == kCaps);

  CHECK(commands.hello(kPatience).scene == "heavy");
  const auto stats = receive<protocol::Stats>(states);
  CHECK(stats.late > 0);
  CHECK(stats.overruns > 0);
  CHECK(stats.end_p50 >= stats.tick_p50);
  CHECK((stats.flags & protocol::kPublishingReduced) != 0);
  CHECK(stats.dropped == 0);
  commands.shutdown(kPatience);
  CHECK(server.process().wait(kPatience) == 0);
}

TEST_CASE("in lockstep no tick is late and nothing gives way") {
  ServerProcess server({"--lockstep"}, kHeavyScene);
  client::CommandLink commands = hold(server);
  client::StateLink states = subscribe(server, {"force", "needle"});
  REQUIRE(commands.send(inside(1)));
  commands.step(3, kPatience);
  for (std::uint64_t tick = 1; tick <= 3; ++tick) {
    CHECK((receive<protocol::Force>(states).flags & kCaps) == 0);
  }
}

}  // namespace acus::testing
