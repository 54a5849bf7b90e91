// SPDX-License-Identifier: GPL-3.0-or-later
// The topic `haptics` over the wire. Its numbers are held by tests/tick/test_base_stiffness.cpp.
#include <doctest/doctest.h>

#include <algorithm>

#include "tests/integration/server_process.h"

namespace acus::testing {

TEST_CASE("haptics tell the force of the same tick, and a stiffness against which a hand works") {
  ServerProcess server({"--lockstep"});
  client::CommandLink commands = hold(server);
  client::StateLink states = subscribe(server, {"force", "haptics"});
  protocol::Pose pose = pose_at(0.5, 1);
  pose.spin = 2;
  pose.time = 7;
  REQUIRE(commands.send(pose));
  commands.step(200, kPatience);
  protocol::Force force;
  protocol::Haptics haptics;
  for (int i = 0; i < 200; ++i) {
    force = receive<protocol::Force>(states);
    haptics = receive<protocol::Haptics>(states);
    REQUIRE(haptics.tick == force.tick);
    CHECK(haptics.force == force.haptic_force);
    CHECK(haptics.torque == force.haptic_torque);
    CHECK(haptics.position == force.base_position);
    CHECK(haptics.position == force.commanded_position);
    CHECK(haptics.orientation == force.commanded_orientation);
    CHECK(haptics.flags == force.flags);
  }
  CHECK(haptics.needle == "needle");
  CHECK(haptics.seq == 1);
  CHECK(haptics.echo == 7);
  CHECK(haptics.spin == doctest::Approx(2).epsilon(1e-6));
  CHECK(std::abs(haptics.orientation.w) == doctest::Approx(1));  // the spin is not in it
  REQUIRE(haptics.stiffness.size() == 36);
  for (std::size_t i = 0; i < 6; ++i) CHECK(haptics.stiffness[7 * i] < 0);
  CHECK(haptics.forward == 1);  // in the air
  CHECK(haptics.forward_yield == 0);
  CHECK(haptics.backward_yield == 0);
  CHECK(haptics.lasting_force == protocol::Vector3{});  // without weight
  CHECK(haptics.forward_limit == protocol::ModelLimit::none);
}

TEST_CASE("of a base on springs, forces and haptics tell where the commands have it, and forces where it is") {
  ServerProcess server(
      {"--lockstep"},
      "acus_scene: 1\nname: held\ntissue: {rung: none}\n"
      "needles: [{beams: 5, base: {position: [0, 0, 0.5]}, smoothing: 0.01,\n"
      "           hold: {stiffness: 50, damping: 0.5, angular_stiffness: 5, angular_damping: 0.01}}]\n");
  client::CommandLink commands = hold(server);
  client::StateLink states = subscribe(server, {"force", "haptics"});
  protocol::Pose pose = pose_at(0.4, 1);
  pose.spin = 1;
  REQUIRE(commands.send(pose));
  commands.step(1500, kPatience);
  double largest = 0;
  protocol::Force force;
  for (int i = 0; i < 1500; ++i) {
    force = receive<protocol::Force>(states);
    const auto haptics = receive<protocol::Haptics>(states);
    REQUIRE(haptics.position == force.commanded_position);
    REQUIRE(haptics.orientation == force.commanded_orientation);
    largest = std::max(largest, std::abs(force.commanded_position[2] - force.base_position[2]));
  }
  CHECK(largest > 1e-4);  // while it moves
  CHECK(force.commanded_position[2] == doctest::Approx(0.4).epsilon(1e-6).scale(0));
  CHECK(std::abs(force.commanded_orientation.w) == doctest::Approx(1));
  CHECK(force.spin == doctest::Approx(1).epsilon(1e-6));
}

TEST_CASE("who listens to haptics does not change the run") {
  const auto hash_after = [](const std::vector<std::string>& topics) {
    ServerProcess server({"--lockstep"});
    client::CommandLink commands = hold(server);
    client::StateLink states = subscribe(server, topics);
    for (std::uint64_t i = 1; i <= 200; ++i) {
      REQUIRE(commands.send(pose_at(0.5 - 2.2e-3 * static_cast<double>(i), i)));
      commands.step(1, kPatience);
    }
    return commands.hash(kPatience).hash;
  };
  CHECK(hash_after({"stats"}) == hash_after({"haptics"}));
}

}  // namespace acus::testing
