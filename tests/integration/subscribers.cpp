// SPDX-License-Identifier: GPL-3.0-or-later
// A subscriber that stalls costs neither the simulation nor anybody else anything.
#include <doctest/doctest.h>

#include "tests/integration/server_process.h"

namespace acus::testing {
namespace {

// Reads forces for a while; returns how many ticks passed, and checks that none is missing.
std::uint64_t follow(client::StateLink& states, std::chrono::milliseconds duration) {
  const protocol::Force first = receive<protocol::Force>(states);
  protocol::Force last = first;
  const auto end = std::chrono::steady_clock::now() + duration;
  while (std::chrono::steady_clock::now() < end) {
    const protocol::Force force = receive<protocol::Force>(states);
    CHECK(force.tick == last.tick + 1);
    last = force;
  }
  return last.tick - first.tick;
}

}  // namespace

TEST_CASE("of two subscribers one stalls: the other misses nothing, and ticks come as fast as before") {
  ServerProcess server({"--rate", "2000"});
  client::StateLink reading = subscribe(server, {"force"});
  const std::uint64_t before = follow(reading, 3s);

  client::StateLink stalled(server.states(), 1);
  for (const char* topic : {"force", "needle", "tissue", "event", "stats"}) stalled.subscribe(topic);
  follow(reading, 4s);  // the queues to the stalled one fill up
  const std::uint64_t after = follow(reading, 3s);
  CHECK(after > before / 2);
}

TEST_CASE("what nobody listens to is not sent, and stats tell what somebody listens to") {
  ServerProcess server;
  client::StateLink states = subscribe(server, {"event", "force"});
  CHECK(receive<protocol::Stats>(states).subscribed == std::vector<std::string>{"force", "event", "stats"});
  states.unsubscribe("event");
  states.unsubscribe("force");
  receive<protocol::Stats>(states);
  CHECK(receive<protocol::Stats>(states).subscribed == std::vector<std::string>{"stats"});
}

}  // namespace acus::testing
