// SPDX-License-Identifier: GPL-3.0-or-later
// Poses that are further away than the scene allows: clamped or ignored, counted, and told to who sent them.
#include <doctest/doctest.h>

#include <cmath>

#include "tests/integration/server_process.h"

namespace acus::testing {
namespace {

std::string scene_with(const std::string& beyond) {
  return small_scene("small") + "clients: {max_step: 0.02, max_turn: 0.1, beyond: " + beyond + "}\n";
}

// The force after the ticks of a step.
protocol::Force step(client::CommandLink& commands, client::StateLink& states, std::uint32_t ticks) {
  commands.step(ticks, kPatience);
  protocol::Force force;
  for (std::uint32_t i = 0; i < ticks; ++i) force = receive<protocol::Force>(states);
  return force;
}

std::string rejection_of(client::CommandLink& commands, std::uint64_t seq) {
  const auto deadline = std::chrono::steady_clock::now() + kPatience;
  while (std::chrono::steady_clock::now() < deadline) {
    const std::optional<protocol::Error> error = commands.next_rejection();
    if (!error) continue;
    CHECK(error->seq == seq);
    CHECK(error->rejected == "pose");
    return std::string(name_of(error->code)) + ": " + error->message;
  }
  return "none";
}

}  // namespace

TEST_CASE("a pose beyond the scene's step is clamped to it, counted, and its sender told") {
  ServerProcess server({"--lockstep"}, scene_with("clamp"));
  client::CommandLink commands = hold(server);
  client::StateLink states = subscribe(server, {"force"});
  REQUIRE(commands.send(pose_at(0.49, 1)));
  CHECK(step(commands, states, 100).base_position[2] == doctest::Approx(0.49));
  REQUIRE(commands.send(pose_at(0.40, 2)));
  const protocol::Force force = step(commands, states, 100);
  CHECK(force.base_position[2] == doctest::Approx(0.47));
  CHECK(force.limited == 1);
  CHECK(force.seq == 2);
  const std::string told = rejection_of(commands, 2);
  CHECK(told.starts_with("beyond_limit: 'needle'"));
  CHECK(told.ends_with("clamped"));
  protocol::Pose turned = pose_at(0.47, 3);
  turned.orientation = {0, 1, 0, 0};
  REQUIRE(commands.send(turned));
  const protocol::Quaternion q = step(commands, states, 100).base_orientation;
  CHECK(2 * std::acos(std::abs(q.w)) == doctest::Approx(0.1).epsilon(0.01));
}

TEST_CASE("where the scene says reject, a pose beyond its step is ignored") {
  ServerProcess server({"--lockstep"}, scene_with("reject"));
  client::CommandLink commands = hold(server);
  client::StateLink states = subscribe(server, {"force"});
  REQUIRE(commands.send(pose_at(0.40, 1)));
  const protocol::Force force = step(commands, states, 100);
  CHECK(force.base_position[2] == 0.5);
  CHECK(force.limited == 1);
  CHECK(force.seq == 0);
  CHECK(rejection_of(commands, 1).ends_with("ignored"));
  REQUIRE(commands.send(pose_at(0.49, 2)));
  CHECK(step(commands, states, 100).base_position[2] == doctest::Approx(0.49));
}

TEST_CASE("a base that goes at its speed limit is told of") {
  ServerProcess server({"--lockstep"});
  client::CommandLink commands = hold(server);
  client::StateLink states = subscribe(server, {"force"});
  CHECK((step(commands, states, 1).flags & protocol::kBaseLimited) == 0);
  REQUIRE(commands.send(pose_at(5, 1)));
  CHECK((step(commands, states, 5).flags & protocol::kBaseLimited) != 0);
  CHECK((step(commands, states, 2000).flags & protocol::kBaseLimited) == 0);
}

}  // namespace acus::testing
