// SPDX-License-Identifier: GPL-3.0-or-later
// A subscriber that stalls costs neither the simulation nor anybody else anything.
#include <doctest/doctest.h>

#include <algorithm>

#include "tests/integration/raw_peer.h"
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

const std::string kCancel(1, '\0'), kSubscribe(1, '\1');

// A subscriber that can be sure that the server has taken in what it sent before.
class RawSubscriber : public RawPeer {
 public:
  explicit RawSubscriber(const ServerProcess& server) : RawPeer(server.states()) { shake_hands("SUB"); }

  // What `stats` tells once everything sent so far has its effect: the second one to come, as the first may have been
  // made before the answer to a doubt.
  std::vector<std::string> subscribed() {
    send_frame(kSubscribe + "stats");
    for (int stats = 0; stats < 2;) {
      const protocol::State state = protocol::decode_state(receive_message());
      if (!std::holds_alternative<protocol::Stats>(state)) continue;
      topics_ = std::get<protocol::Stats>(state).subscribed;
      ++stats;
    }
    return topics_;
  }

 private:
  std::vector<std::string> topics_;
};

using Topics = std::vector<std::string>;

// Waits for the server to notice that a subscriber is gone.
bool comes_to(client::StateLink& states, const Topics& topics) {
  const auto deadline = std::chrono::steady_clock::now() + kPatience;
  while (std::chrono::steady_clock::now() < deadline) {
    if (receive<protocol::Stats>(states).subscribed == topics) return true;
  }
  return false;
}

}  // namespace

TEST_CASE("the first to listen to stats is told how long ticks take, right after the start too") {
  const ServerProcess server;
  client::StateLink states(server.states());
  states.subscribe("stats");
  const auto first = receive<protocol::Stats>(states);
  CHECK(first.ticks > 0);
  CHECK(first.end_p50 > 0);
  CHECK(first.period < 1);
}

TEST_CASE("of two subscribers one stalls: the other misses nothing, and ticks come as fast as before" *
          doctest::test_suite("full")) {
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

TEST_CASE("a peer cannot cancel what others subscribed to") {
  ServerProcess server;
  client::StateLink states = subscribe(server, {"force"});
  RawSubscriber peer(server);
  for (int i = 0; i < 3; ++i) peer.send_frame(kCancel + "force");
  peer.send_command("CANCEL", "force");
  for (const char* prefix : {"", "f", "fo", "forces", "stats"}) peer.send_frame(kCancel + prefix);
  CHECK(peer.subscribed() == Topics{"force", "stats"});
  const std::uint64_t tick = receive<protocol::Stats>(states).tick;
  while (receive<protocol::Force>(states).tick < tick) continue;
  CHECK(receive<protocol::Stats>(states).subscribed == Topics{"force", "stats"});
}

TEST_CASE("who subscribed twice is gone after one cancel") {
  ServerProcess server;
  RawSubscriber peer(server);
  for (int i = 0; i < 2; ++i) peer.send_frame(kSubscribe + "needle");
  peer.send_command("SUBSCRIBE", "event");
  CHECK(peer.subscribed() == Topics{"needle", "event", "stats"});
  peer.send_frame(kCancel + "needle");
  peer.send_command("CANCEL", "event");
  CHECK(peer.subscribed() == Topics{"stats"});
}

TEST_CASE("prefixes are counted each by itself") {
  ServerProcess server;
  RawSubscriber peer(server);
  for (const char* prefix : {"", "f", "fo", "n"}) peer.send_frame(kSubscribe + prefix);
  CHECK(peer.subscribed() == Topics{"force", "needle", "tissue", "event", "stats", "haptics"});
  for (const char* prefix : {"", "f"}) peer.send_frame(kCancel + prefix);
  CHECK(peer.subscribed() == Topics{"force", "needle", "stats"});
  for (const char* prefix : {"fo", "n"}) peer.send_frame(kCancel + prefix);
  CHECK(peer.subscribed() == Topics{"stats"});
}

TEST_CASE("what a peer subscribed to ends with it, and nothing else does") {
  ServerProcess server;
  client::StateLink states = subscribe(server, {"force"});
  {
    RawSubscriber dying(server);
    for (const char* prefix : {"force", "fo", "needle", "needle", "n", "tissue"}) {
      dying.send_frame(kSubscribe + prefix);
    }
    CHECK(dying.subscribed() == Topics{"force", "needle", "tissue", "stats"});
  }
  CHECK(comes_to(states, {"force", "stats"}));
}

TEST_CASE("whatever else comes up the states socket is ignored") {
  ServerProcess server;
  client::StateLink states = subscribe(server, {"force"});
  RawSubscriber peer(server);
  for (const std::string& bytes : {std::string(), std::string("force"), std::string("\2force"), kSubscribe + "nothing",
                                   kSubscribe + std::string(200, 'x'), kCancel + std::string(200, 'x')}) {
    peer.send_frame(bytes);
  }
  peer.send_frame("a message", /*more=*/true);
  peer.send_frame(kCancel + "force", /*more=*/true);
  peer.send_frame("of three frames");
  peer.send_command("NOTHING", "known");
  CHECK(peer.subscribed() == Topics{"force", "stats"});
  CHECK(comes_to(states, {"force", "stats"}));
}

}  // namespace acus::testing
