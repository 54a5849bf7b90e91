// SPDX-License-Identifier: GPL-3.0-or-later
// What goes wrong around a server: clients that stand still, no descriptors, no memory, no processor, a wall clock that
// steps. Full disks and servers that are killed: recordings.cpp, snapshots.cpp; subscribers that do not read:
// subscribers.cpp; clients that vanish: holders.cpp, life_and_death.cpp.
#include <doctest/doctest.h>

#include <csignal>
#include <deque>
#include <memory>
#include <thread>

#include "tests/integration/raw_peer.h"
#include "tests/integration/server_process.h"
#include "tests/integration/tcp_server.h"
#include "tests/support/places.h"

namespace acus::testing {
namespace {

// Every tick of a needle, from a link of its own.
class Observer {
 public:
  explicit Observer(const ServerProcess& server) : states_(subscribe(server, {"force"})) {}

  protocol::Force next() {
    const auto force = receive<protocol::Force>(states_);
    if (last_ > 0) CHECK(force.tick == last_ + 1);
    last_ = force.tick;
    return force;
  }
  template <class Condition>
  protocol::Force wait_for(Condition condition) {
    const auto deadline = std::chrono::steady_clock::now() + kPatience;
    protocol::Force force;
    do force = next();
    while (!condition(force) && std::chrono::steady_clock::now() < deadline);
    CHECK(condition(force));
    return force;
  }

 private:
  client::StateLink states_;
  std::uint64_t last_ = 0;
};

std::string slow_descent(const TemporaryFolder& folder) {
  folder.write("descent.csv",
               "t,needle,x,y,z,qw,qx,qy,qz,spin\n0,needle,0,0,0.5,1,0,0,0,0\n30,needle,0,0,0.2,1,0,0,0,0\n");
  return folder / "descent.csv";
}

// Keeps a processor busy while it lives.
std::unique_ptr<Process> busy() {
  return std::make_unique<Process>(std::vector<std::string>{"/bin/sh", "-c", "while :; do :; done"});
}

}  // namespace

TEST_CASE(
    "a client that is stopped leaves its needle at rest, loses nobody a state, and goes on when it is continued") {
  ServerProcess server;
  Observer observer(server);
  Process client({program_path("acus-replay"), slow_descent(server.folder()), "--commands", server.commands(),
                  "--states", server.states()});
  const protocol::Force moving = observer.wait_for([](const auto& f) { return f.base_position[2] < 0.498; });
  CHECK(!moving.stale);
  client.send_signal(SIGSTOP);
  observer.wait_for([](const auto& f) { return f.stale; });
  for (int i = 0; i < 60; ++i) observer.next();  // the base comes to rest
  const protocol::Force resting = observer.next();
  for (int i = 0; i < 20; ++i) CHECK(observer.next().base_position == resting.base_position);
  CHECK(resting.haptic_force == protocol::Vector3{});
  client.send_signal(SIGCONT);
  observer.wait_for([](const auto& f) { return !f.stale; });
  observer.wait_for([&](const auto& f) { return f.base_position[2] < resting.base_position[2] - 1e-3; });
}

// Over TCP.
TEST_CASE("a server without descriptors left goes on for those it serves, and serves others once there are") {
  const TcpServer server({"/usr/bin/prlimit", "--nofile=64:64"});
  client::CommandLink commands(server.commands());
  commands.acquire({"needle"}, kPatience);
  {
    std::vector<std::unique_ptr<client::CommandLink>> crowd;
    for (int i = 0; i < 60; ++i) crowd.push_back(std::make_unique<client::CommandLink>(server.commands()));
    for (std::uint64_t i = 1; i <= 50; ++i) {
      REQUIRE(commands.send(pose_at(0.49, i)));
      CHECK(commands.hello(kPatience).held == std::vector<std::string>{"needle"});
      std::this_thread::sleep_for(10ms);
    }
  }
  client::CommandLink newcomer(server.commands());
  CHECK(newcomer.hello(kPatience).held == std::vector<std::string>{"needle"});
}

TEST_CASE("over ipc, too, where more come at once than there are descriptors") {
  ServerProcess server({}, small_scene("small"), {"/usr/bin/prlimit", "--nofile=64:64"});
  client::CommandLink commands(server.commands());
  commands.acquire({"needle"}, kPatience);
  for (int wave = 0; wave < 5; ++wave) {
    std::deque<RawPeer> crowd;  // faster than the server can end them
    for (int i = 0; i < 150; ++i) crowd.emplace_back(server.commands());
    CHECK(commands.hello(kPatience).held == std::vector<std::string>{"needle"});
  }
  client::CommandLink newcomer(server.commands());
  CHECK(newcomer.hello(kPatience).held == std::vector<std::string>{"needle"});
}

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)  // which need address space, and to be loaded first

TEST_CASE("a scene that needs more memory than there is is refused, and the one before goes on") {
  ServerProcess server({}, small_scene("small"), {"/usr/bin/prlimit", "--as=900000000"});
  client::CommandLink commands(server.commands());
  CHECK(commands.hello(kPatience).scene == "small");
  Observer observer(server);
  std::string large = small_scene("large");
  large.replace(large.find("cells: [3, 3, 3]"), 16, "cells: [44, 44, 44]");
  try {
    commands.load_text(large, 5 * kPatience);
    FAIL("there was memory enough");
  } catch (const client::Refused& refused) {
    CHECK(std::string(name_of(refused.error.code)) == "scene_error");
    CHECK(refused.error.message.find("memory") != std::string::npos);
  }
  CHECK(commands.hello(kPatience).scene == "small");
  observer.next();
}

TEST_CASE("steps of the wall clock change nothing") {
  const std::vector<std::string> stepping{"/usr/bin/env", "LD_PRELOAD=" + program_path("libacus_clock_steps.so")};
  const auto hash_after = [](const std::vector<std::string>& before) {
    ServerProcess server({"--lockstep"}, small_scene("small"), before);
    client::CommandLink commands = hold(server);
    REQUIRE(commands.send(pose_at(0.4, 1)));
    commands.step(50, kPatience);
    return commands.hash(kPatience).hash;
  };
  CHECK(hash_after(stepping) == hash_after({}));
  ServerProcess server({}, small_scene("small"), stepping);
  client::CommandLink commands = hold(server);
  Observer observer(server);
  REQUIRE(commands.send(pose_at(0.45, 1)));
  observer.wait_for([](const auto& f) { return f.stale; });
  client::StateLink states = subscribe(server, {});
  const auto stats = receive<protocol::Stats>(states);
  CHECK(stats.period < 3600);
  CHECK(stats.wake_max < 3600);
}

#endif

TEST_CASE("with every processor busy ticks come late and are counted, and no state is lost" *
          doctest::test_suite("clock")) {
  ServerProcess server;
  client::CommandLink commands = hold(server);
  Observer observer(server);
  std::vector<std::unique_ptr<Process>> others;
  for (unsigned i = 0; i < 2 * std::thread::hardware_concurrency(); ++i) others.push_back(busy());
  for (std::uint64_t seq = 1; seq <= 200; ++seq) {
    REQUIRE(commands.send(pose_at(0.5 - 1e-3 * static_cast<double>(seq), seq)));
    observer.next();
  }
  CHECK(observer.wait_for([](const auto& f) { return f.seq == 200; }).flags == 0);
  client::StateLink states = subscribe(server, {});
  CHECK(receive<protocol::Stats>(states).dropped == 0);
}

}  // namespace acus::testing
