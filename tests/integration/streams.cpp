// SPDX-License-Identifier: GPL-3.0-or-later
// Commands move needles, and states say which command they used.
#include <doctest/doctest.h>

#include <cmath>

#include "tests/integration/server_process.h"

namespace acus::testing {

TEST_CASE("poses come back in the forces, and no tick is missing") {
  ServerProcess server;
  client::CommandLink commands = hold(server);
  client::StateLink states = subscribe(server, {"force"});
  protocol::Force last = receive<protocol::Force>(states);
  for (std::uint64_t i = 1; i <= 200; ++i) {
    REQUIRE(commands.send(pose_at(0.5 + 1e-5 * static_cast<double>(i), i)));
    const protocol::Force force = receive<protocol::Force>(states);
    CHECK(force.tick == last.tick + 1);
    CHECK(force.seq >= last.seq);
    CHECK(force.seq <= i);
    CHECK(force.age >= 0);
    last = force;
  }
  while (last.seq != 200) last = receive<protocol::Force>(states);
  CHECK_FALSE(commands.next_rejection());
}

TEST_CASE("spin alone turns the needle and leaves it where it was commanded to be") {
  ServerProcess server({"--lockstep"});
  client::CommandLink commands = hold(server);
  client::StateLink states = subscribe(server, {"force"});
  REQUIRE(commands.send(pose_at(0.501, 1)));
  commands.step(200, kPatience);
  REQUIRE(commands.send(protocol::Spin{"needle", 2, 0, 0.5}));
  const std::uint64_t end = commands.step(200, kPatience).tick;
  protocol::Force force = receive<protocol::Force>(states);
  while (force.tick < end) force = receive<protocol::Force>(states);
  CHECK(force.seq == 2);
  CHECK(force.spin == doctest::Approx(0.5).epsilon(5e-6).scale(0));
  CHECK(force.base_position[2] == doctest::Approx(0.501).epsilon(5e-6).scale(0));
}

TEST_CASE("shapes have the sizes that hello tells") {
  ServerProcess server;
  client::CommandLink commands(server.commands());
  const protocol::HelloReply hello = commands.hello(kPatience);
  client::StateLink states = subscribe(server, {"needle", "tissue"});
  const auto needle = receive<protocol::NeedleShape>(states);
  CHECK(needle.needle == "needle");
  CHECK(needle.positions.size() == 3 * hello.needles[0].nodes);
  REQUIRE(needle.orientations.size() == 4 * hello.needles[0].nodes);
  CHECK(std::hypot(std::hypot(needle.orientations[0], needle.orientations[1]),
                   std::hypot(needle.orientations[2], needle.orientations[3])) == doctest::Approx(1));
  CHECK(receive<protocol::TissueShape>(states).positions.size() == 3 * hello.tissue.nodes);
}

}  // namespace acus::testing
