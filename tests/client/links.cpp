// SPDX-License-Identifier: GPL-3.0-or-later
// The two links of the client library against a scripted peer.
#include <doctest/doctest.h>

#include <chrono>
#include <thread>
#include <variant>

#include "client/link/client.h"
#include "tests/client/mock_server.h"

using namespace std::chrono_literals;
using namespace acus::client;
using acus::test::MockScript;
using acus::test::MockServer;

namespace {

constexpr Timeout kPatience = 20s;  // never waited for in full unless something is broken

template <class State>
State await(StateLink& states) {
  const auto deadline = std::chrono::steady_clock::now() + kPatience;
  while (std::chrono::steady_clock::now() < deadline) {
    const auto state = states.receive(100ms);
    if (state && std::holds_alternative<State>(*state)) return std::get<State>(*state);
  }
  throw std::runtime_error("the state never came");
}

acus::protocol::Pose pose_of(const char* needle, std::uint64_t seq) {
  acus::protocol::Pose pose;
  pose.needle = needle;
  pose.seq = seq;
  return pose;
}

}  // namespace

TEST_CASE("hello tells what the server has" * doctest::test_suite("gate")) {
  MockServer server;
  CommandLink commands(server.commands());
  const auto hello = commands.hello(kPatience);
  CHECK(hello.scene == "mock scene");
  REQUIRE(hello.needles.size() == 1);
  CHECK(hello.needles[0].name == "needle");
}

TEST_CASE("a client that is older than its server waits for it" * doctest::test_suite("gate")) {
  MockServer server({}, 300);
  CommandLink commands(server.commands());
  StateLink states(server.states());
  states.subscribe("force");
  CHECK(commands.hello(kPatience).rate == 200);
  CHECK(await<acus::protocol::Force>(states).needle == "needle");
}

TEST_CASE("nobody at the endpoint is a Vanished that names it, within the timeout" * doctest::test_suite("gate")) {
  std::string endpoint;
  {
    MockServer server;
    endpoint = server.commands();
  }
  CommandLink commands(endpoint);
  CHECK_FALSE(commands.send(pose_of("needle", 1)));
  try {
    commands.hello(50ms);
    FAIL("hello came back");
  } catch (const Vanished& error) {
    CHECK(std::string(error.what()).find(endpoint) != std::string::npos);
  }
}

TEST_CASE("a server that hears but does not answer is a Vanished" * doctest::test_suite("gate")) {
  MockScript script;
  script.mute = true;
  MockServer server(script);
  CommandLink commands(server.commands());
  CHECK_THROWS_AS(commands.hello(300ms), Vanished);
}

TEST_CASE("a refused request is a Refused with the server's code and words" * doctest::test_suite("gate")) {
  MockScript script;
  script.rejects_requests = true;
  MockServer server(script);
  CommandLink commands(server.commands());
  try {
    commands.hello(kPatience);
    FAIL("hello came back");
  } catch (const Refused& error) {
    CHECK(error.error.code == acus::protocol::ErrorCode::busy);
    CHECK(std::string(error.what()) == "the server refused 'hello' (busy): as the script says");
  }
}

TEST_CASE("another version of the protocol is a ProtocolMismatch" * doctest::test_suite("gate")) {
  MockScript script;
  script.version = 99;
  MockServer server(script);
  CommandLink commands(server.commands());
  CHECK_THROWS_AS(commands.hello(kPatience), ProtocolMismatch);
}

TEST_CASE("an endpoint that ZeroMQ does not know is told" * doctest::test_suite("gate")) {
  CHECK_THROWS_AS(CommandLink("bogus"), ClientError);
  CHECK_THROWS_AS(StateLink("bogus"), ClientError);
}

TEST_CASE("a rejected pose comes back as a rejection, also while a request waits for its answer" *
          doctest::test_suite("gate")) {
  MockScript script;
  script.rejects_poses = true;
  MockServer server(script);
  CommandLink commands(server.commands());
  commands.hello(kPatience);
  CHECK_FALSE(commands.next_rejection().has_value());
  REQUIRE(commands.send(pose_of("needle", 1)));
  REQUIRE(commands.send(pose_of("needle", 2)));
  commands.hello(kPatience);
  CHECK(commands.next_rejection().value().seq == 1);
  CHECK(commands.next_rejection().value().seq == 2);
  CHECK_FALSE(commands.next_rejection().has_value());
}

TEST_CASE("statistics prove that earlier subscriptions are in effect; other topics do not come" *
          doctest::test_suite("gate")) {
  MockScript script;
  script.lockstep = true;
  MockServer server(script);
  CommandLink commands(server.commands());
  StateLink states(server.states());
  states.subscribe("force");
  states.subscribe("stats");
  await<acus::protocol::Stats>(states);
  const auto done = commands.step(10, kPatience);
  CHECK(done.tick == 10);
  for (std::uint64_t tick = 1; tick <= 10; ++tick) CHECK(await<acus::protocol::Force>(states).tick == tick);
}

TEST_CASE("a server that ends under its client is noticed by both links" * doctest::test_suite("gate")) {
  auto server = std::make_unique<MockServer>();
  CommandLink commands(server->commands());
  StateLink states(server->states());
  states.subscribe("force");
  commands.hello(kPatience);
  await<acus::protocol::Force>(states);
  server.reset();
  CHECK_THROWS_AS(commands.hello(300ms), Vanished);
  while (states.receive(100ms)) {  // what was on its way
  }
  CHECK_FALSE(states.receive(10ms).has_value());
}
