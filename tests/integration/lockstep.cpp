// SPDX-License-Identifier: GPL-3.0-or-later
// In lockstep the client makes time: ticks run when it asks, all their states arrive, and the run can be repeated.
#include <doctest/doctest.h>

#include "tests/integration/server_process.h"

namespace acus::testing {
namespace {

// The forces of a run of 60 commands, 10 ticks each, as encoded bytes. Poses and steps are sent without a pause.
std::vector<std::string> record_run() {
  ServerProcess server({"--lockstep"});
  client::CommandLink commands = hold(server);
  client::StateLink states = subscribe(server, {"force"});
  std::uint64_t end = 0;
  for (std::uint64_t i = 1; i <= 60; ++i) {
    CHECK(commands.send(pose_at(0.5 - 1e-4 * static_cast<double>(i), i)));
    end = commands.step(10, kPatience).tick;
  }
  std::vector<std::string> forces;
  while (forces.size() < end) forces.push_back(encode(receive<protocol::Force>(states)));
  return forces;
}

}  // namespace

TEST_CASE("no tick runs by itself; a step runs as many as it says, with the commands sent before it") {
  ServerProcess server({"--lockstep"});
  client::CommandLink commands = hold(server);
  CHECK(commands.hello(kPatience).lockstep);
  client::StateLink states = subscribe(server, {"force"});
  REQUIRE(commands.send(pose_at(0.5, 3)));
  CHECK(commands.step(1, kPatience).tick == 1);
  CHECK(commands.step(4, kPatience).tick == 5);
  REQUIRE(commands.send(pose_at(0.5, 4)));
  const protocol::Done done = commands.step(5, kPatience);
  CHECK(done.tick == 10);
  CHECK(done.time == doctest::Approx(10.0 / 200));
  for (std::uint64_t tick = 1; tick <= 10; ++tick) {
    const auto force = receive<protocol::Force>(states);
    CHECK(force.tick == tick);
    CHECK(force.seq == (tick <= 5 ? 3 : 4));
    CHECK(force.age == doctest::Approx(static_cast<double>((tick - 1) % 5) / 200));
  }
}

TEST_CASE("a long step ends with its client, and others are answered") {
  ServerProcess server({"--lockstep"});
  client::CommandLink other(server.commands());
  other.hello(kPatience);
  {
    client::CommandLink commands(server.commands());
    for (int i = 0; i < 5; ++i) CHECK_THROWS_AS(commands.step(100'000, 50ms), client::Vanished);
  }
  const std::uint64_t tick = other.hash(kPatience).tick;
  CHECK(tick > 0);
  CHECK(tick < 100'000);
}

TEST_CASE("a long step loses no state, although the subscriber reads only afterwards") {
  constexpr std::uint64_t kTicks = 20000;
  ServerProcess server({"--lockstep"});
  client::CommandLink commands(server.commands());
  client::StateLink states = subscribe(server, {"force"});
  CHECK(commands.step(kTicks, kPatience).tick == kTicks);
  for (std::uint64_t tick = 1; tick <= kTicks; ++tick) REQUIRE(receive<protocol::Force>(states).tick == tick);
}

TEST_CASE("the same commands give the same bytes") {
  const std::vector<std::string> first = record_run(), second = record_run();
  CHECK(first.size() == 600);
  CHECK(first == second);
}

TEST_CASE("reset and load in lockstep take effect before the next message") {
  ServerProcess server({"--lockstep"});
  client::CommandLink commands(server.commands());
  commands.step(3, kPatience);
  CHECK(commands.reset(kPatience).tick == 0);
  CHECK(commands.step(2, kPatience).tick == 2);
  const protocol::Done loaded = commands.load(server.scene(), kPatience);
  CHECK(loaded.epoch == 2);
  CHECK(loaded.tick == 0);
  CHECK(commands.step(1, kPatience).tick == 1);
}

TEST_CASE("a subscriber that never reads holds lockstep up for a while, but not for ever" *
          doctest::test_suite("full")) {
  ServerProcess server({"--lockstep"});
  client::CommandLink commands(server.commands());
  client::StateLink stalled(server.states(), 1);
  stalled.subscribe("");
  commands.hello(kPatience);
  CHECK(commands.step(40000, 2 * kPatience).tick == 40000);
}

}  // namespace acus::testing
