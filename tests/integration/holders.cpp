// SPDX-License-Identifier: GPL-3.0-or-later
// Who may command what, and what becomes of a needle whose client is silent or gone.
#include <doctest/doctest.h>

#include <cmath>
#include <csignal>
#include <functional>
#include <thread>
#include <zmq.hpp>

#include "tests/integration/server_process.h"

namespace acus::testing {

namespace {

std::string refusal(const std::function<void()>& request) {
  try {
    request();
    return "none";
  } catch (const client::Refused& refused) {
    return name_of(refused.error.code);
  }
}

std::string rejection(client::CommandLink& commands) {
  commands.hello(kPatience);  // answered after what came before it
  const std::optional<protocol::Error> error = commands.next_rejection();
  return error ? name_of(error->code) : "none";
}

}  // namespace

TEST_CASE("who does not hold a needle does not move it") {
  ServerProcess server({"--lockstep"});
  client::CommandLink commands(server.commands());
  client::StateLink states = subscribe(server, {"force"});
  commands.hello(kPatience);
  REQUIRE(commands.send(pose_at(0.4, 5)));
  CHECK(rejection(commands) == "not_holder");
  commands.step(1, kPatience);
  CHECK(receive<protocol::Force>(states).seq == 0);
  CHECK(commands.acquire({"needle"}, kPatience).needles == std::vector<std::string>{"needle"});
  REQUIRE(commands.send(pose_at(0.4, 6)));
  commands.step(1, kPatience);
  CHECK(receive<protocol::Force>(states).seq == 6);
}

TEST_CASE("one client at a time holds a needle, until it releases it or is gone") {
  ServerProcess server({}, small_scene("pair", {"left", "right"}));
  client::CommandLink second(server.commands());
  {
    client::CommandLink first = hold(server, {"left"});
    CHECK(second.hello(kPatience).held == std::vector<std::string>{"left"});
    CHECK(refusal([&] { second.acquire({"right", "left"}, kPatience); }) == "held");
    CHECK(second.hello(kPatience).held == std::vector<std::string>{"left"});  // all or nothing
    CHECK(refusal([&] { second.acquire({"none"}, kPatience); }) == "unknown_needle");
    CHECK(refusal([&] { second.acquire({"right", "right", "right"}, kPatience); }) == "bad_value");
    CHECK(second.acquire({"right"}, kPatience).needles == std::vector<std::string>{"right"});
    CHECK(first.acquire({"left"}, kPatience).needles.size() == 1);  // its own, once more
    CHECK(first.release({"left", "right"}, kPatience).needles.empty());
    CHECK(second.acquire({"left"}, kPatience).needles.size() == 2);
    second.release({"left"}, kPatience);
    first.acquire({"left"}, kPatience);
  }
  const auto deadline = std::chrono::steady_clock::now() + kPatience;
  while (refusal([&] { second.acquire({"left"}, kPatience); }) == "held" && std::chrono::steady_clock::now() < deadline)
    std::this_thread::sleep_for(10ms);
  CHECK(second.hello(kPatience).held.size() == 2);
}

TEST_CASE("who acquires with its last words holds nothing") {
  ServerProcess server;
  client::CommandLink(server.commands()).hello(kPatience);
  for (int i = 0; i < 50; ++i) {
    zmq::context_t context;
    zmq::socket_t socket(context, zmq::socket_type::dealer);
    socket.connect(server.commands());
    socket.send(zmq::buffer(encode(protocol::Acquire{{1, {"needle"}}})));
  }
  client::CommandLink next(server.commands());
  const auto deadline = std::chrono::steady_clock::now() + 10s;
  while (refusal([&] { next.acquire({"needle"}, kPatience); }) == "held" && std::chrono::steady_clock::now() < deadline)
    std::this_thread::sleep_for(10ms);
  REQUIRE(next.send(pose_at(0.4, 1)));
  CHECK(rejection(next) == "none");
}

TEST_CASE("a scene may let any number of clients hold a needle") {
  ServerProcess server({"--lockstep"}, small_scene("shared") + "clients: {holding: any}\n");
  client::CommandLink first = hold(server), second = hold(server);
  REQUIRE(first.send(pose_at(0.5, 1)));
  CHECK(rejection(first) == "none");
  REQUIRE(second.send(pose_at(0.5, 2)));
  CHECK(rejection(second) == "none");
}

TEST_CASE("who holds nothing does not change the world while others hold something") {
  ServerProcess server;
  client::CommandLink holder = hold(server), watcher(server.commands());
  const protocol::SnapshotReply snapshot = watcher.snapshot(kPatience);
  CHECK(refusal([&] { watcher.pause(kPatience); }) == "not_holder");
  CHECK(refusal([&] { watcher.reset(kPatience); }) == "not_holder");
  CHECK(refusal([&] { watcher.restore(snapshot.snapshot, kPatience); }) == "not_holder");
  CHECK(refusal([&] { watcher.load(server.scene(), kPatience); }) == "not_holder");
  CHECK(refusal([&] { watcher.shutdown(kPatience); }) == "not_holder");
  CHECK(watcher.hello(kPatience).epoch == 0);
  CHECK(holder.reset(kPatience).epoch == 1);
  CHECK(holder.hello(kPatience).held.size() == 1);  // and holds it still
  CHECK(holder.load(server.scene(), kPatience).epoch == 2);
  CHECK(holder.hello(kPatience).held.empty());  // of another world nothing
  CHECK(watcher.reset(kPatience).epoch == 3);
}

TEST_CASE("poses that waited while the server was away do not move the next one's needles") {
  ServerProcess server;
  zmq::context_t context;
  zmq::socket_t socket(context, zmq::socket_type::dealer);
  socket.set(zmq::sockopt::linger, 0);
  socket.set(zmq::sockopt::rcvtimeo, static_cast<int>(kPatience.count()));
  socket.connect(server.commands());
  const auto reply = [&] {
    zmq::message_t message;
    REQUIRE(socket.recv(message));
    return protocol::decode_reply(message.to_string_view());
  };
  socket.send(zmq::buffer(encode(protocol::Acquire{{1, {"needle"}}})));
  CHECK(std::get<protocol::Holding>(reply()).needles.size() == 1);
  const std::uint64_t instance = client::CommandLink(server.commands()).hello(kPatience).instance;

  server.process().send_signal(SIGKILL);
  CHECK(server.process().wait(kPatience) == -SIGKILL);
  for (std::uint64_t i = 1; i <= 5; ++i) socket.send(zmq::buffer(encode(pose_at(0.3, i))));
  Process next(server.command_line({"--lockstep"}));
  CHECK(std::get<protocol::Error>(reply()).code == protocol::ErrorCode::not_holder);
  client::CommandLink commands(server.commands());
  client::StateLink states = subscribe(server, {"force"});
  commands.step(1, kPatience);
  CHECK(receive<protocol::Force>(states).seq == 0);
  CHECK(commands.hello(kPatience).instance != instance);
}

TEST_CASE("a needle whose client falls silent comes to rest, says so, and goes on without a jump") {
  ServerProcess server({}, small_scene("silent") + "clients: {stale_after: 0.2, ramp: 0.1}\n");
  client::CommandLink commands = hold(server);
  client::StateLink states = subscribe(server, {"force"});
  const double start = receive<protocol::Force>(states).base_position[2];
  protocol::Pose far = pose_at(start + 50, 1);  // a minute away at the needle's speed
  far.time = 12.5;
  REQUIRE(commands.send(far));
  protocol::Force force = receive<protocol::Force>(states);
  while (!force.stale) {
    force = receive<protocol::Force>(states);
    if (force.seq == 1) CHECK(force.echo == 12.5);
  }
  CHECK(force.age > 0.2);
  CHECK(force.age < 0.22);
  CHECK(force.fresh < 0.02);
  for (int i = 0; i < 40; ++i) force = receive<protocol::Force>(states);
  const double rest = force.base_position[2];
  CHECK(rest > start + 0.1);
  CHECK(rest < start + 1);
  CHECK(std::hypot(force.haptic_force[0], force.haptic_force[1], force.haptic_force[2]) == 0);
  for (int i = 0; i < 20; ++i) force = receive<protocol::Force>(states);
  CHECK(force.base_position[2] == doctest::Approx(rest).epsilon(1e-9));
  CHECK(force.seq == 1);

  REQUIRE(commands.send(pose_at(start + 50, 4)));
  while (force.seq != 4) force = receive<protocol::Force>(states);
  CHECK_FALSE(force.stale);
  CHECK(force.lost == 2);
  CHECK(std::abs(force.base_position[2] - rest) < 0.011);  // a tick's way at the needle's speed
}

TEST_CASE("a needle whose client is gone comes to rest at once, whatever silence the scene allows") {
  ServerProcess server({}, small_scene("gone") + "clients: {stale_after: 60, ramp: 0.1}\n");
  client::StateLink states = subscribe(server, {"force"});
  {
    client::CommandLink commands = hold(server);
    REQUIRE(commands.send(pose_at(50, 1)));  // a minute away at the needle's speed
    while (receive<protocol::Force>(states).seq != 1) continue;
  }
  protocol::Force force = receive<protocol::Force>(states);
  while (!force.stale && force.age < 60) force = receive<protocol::Force>(states);
  CHECK(force.stale);
  for (int i = 0; i < 40; ++i) force = receive<protocol::Force>(states);
  const double rest = force.base_position[2];
  for (int i = 0; i < 20; ++i) force = receive<protocol::Force>(states);
  CHECK(force.base_position[2] == doctest::Approx(rest).epsilon(1e-9));
  CHECK(std::hypot(force.haptic_force[0], force.haptic_force[1], force.haptic_force[2]) == 0);

  client::CommandLink next = hold(server);
  REQUIRE(next.send(pose_at(rest, 7)));
  while (force.seq != 7) force = receive<protocol::Force>(states);
  CHECK_FALSE(force.stale);
}

TEST_CASE("what one holder wanted ends with it") {
  ServerProcess server({"--lockstep"});
  client::StateLink states = subscribe(server, {"force"});
  client::CommandLink first = hold(server), second(server.commands());
  const auto height_after = [&](std::uint32_t ticks) {
    const std::uint64_t end = second.step(ticks, kPatience).tick;
    protocol::Force force = receive<protocol::Force>(states);
    while (force.tick < end) force = receive<protocol::Force>(states);
    return force.base_position[2];
  };
  first.release({"needle"}, kPatience);
  const double start = height_after(1);
  first.acquire({"needle"}, kPatience);
  REQUIRE(first.send(pose_at(start + 0.01, 1)));
  first.release({"needle"}, kPatience);
  second.acquire({"needle"}, kPatience);
  CHECK(height_after(100) == doctest::Approx(start + 0.01).epsilon(1e-6));
  REQUIRE(second.send(pose_at(start, 1)));
  CHECK(height_after(100) == doctest::Approx(start).epsilon(1e-6));
  second.release({"needle"}, kPatience);
  first.acquire({"needle"}, kPatience);
  REQUIRE(first.send(protocol::Spin{"needle", 2, 0, 0.5}));
  first.release({"needle"}, kPatience);
  CHECK(height_after(100) == doctest::Approx(start).epsilon(1e-6));  // its old pose came not back
}

TEST_CASE("in lockstep no client is late") {
  ServerProcess server({"--lockstep"});
  client::CommandLink commands = hold(server);
  client::StateLink states = subscribe(server, {"force"});
  REQUIRE(commands.send(pose_at(0.4, 1)));
  const std::uint64_t end = commands.step(200, kPatience).tick;  // a second
  protocol::Force force = receive<protocol::Force>(states);
  while (force.tick < end) force = receive<protocol::Force>(states);
  CHECK_FALSE(force.stale);
  CHECK(force.base_position[2] == doctest::Approx(0.4).epsilon(1e-6));
}

}  // namespace acus::testing
