// SPDX-License-Identifier: GPL-3.0-or-later
// How a server begins and ends, and what its clients see of it.
#include <doctest/doctest.h>
#include <signal.h>

#include <thread>

#include "tests/integration/server_process.h"
#include "tests/support/places.h"

namespace acus::testing {
namespace {

constexpr int kEnded = 0, kBadCommandLine = 1, kBadScene = 2, kCannotListen = 3;

constexpr std::chrono::milliseconds kAtOnce = 20s;  // on a busy machine

// Takes a minute to factorise.
const std::string kEndless =
    "{acus_scene: 1, name: endless, tissue: {mesh: {box: {size: [0.1, 0.1, 0.1], cells: [45, 45, 45]}}}}";

void wait_until_up(const ServerProcess& server) { client::CommandLink(server.commands()).hello(kPatience); }

}  // namespace

TEST_CASE("SIGTERM, SIGINT and SIGHUP end the server with status 0, in both modes") {
  for (int signal : {SIGTERM, SIGINT, SIGHUP}) {
    for (const std::vector<std::string>& options : {std::vector<std::string>{}, {"--lockstep"}}) {
      ServerProcess server(options);
      wait_until_up(server);
      server.process().send_signal(signal);
      CHECK(server.process().wait(kPatience) == kEnded);
    }
  }
}

TEST_CASE("SIGTERM and shutdown end a server whose ticks are a second apart") {
  ServerProcess slow({"--rate", "1"}), asked({"--rate", "1"});
  wait_until_up(slow);
  slow.process().send_signal(SIGTERM);
  CHECK(slow.process().wait(kPatience) == kEnded);
  client::CommandLink(asked.commands()).shutdown(kPatience);
  CHECK(asked.process().wait(kPatience) == kEnded);
}

TEST_CASE("rates that no clock keeps are refused, in a scene and on the command line") {
  for (const std::string rate : {"1e300", "1e-9", "0", "-1", "nan", "inf", "fast"}) {
    CAPTURE(rate);
    CHECK(ServerProcess({"--check", "--rate", rate}).process().wait(kPatience) == kBadCommandLine);
    CHECK(ServerProcess({"--check"}, "{acus_scene: 1, rate: " + rate + "}").process().wait(kPatience) == kBadScene);
  }
  CHECK(ServerProcess({"--check", "--rate", "100000"}).process().wait(kPatience) == kEnded);
  CHECK(ServerProcess({"--check"}, "{acus_scene: 1, rate: 1e5, publish: {needle_rate: 1e-300}}")
            .process()
            .wait(kPatience) == kBadScene);
}

TEST_CASE("a server ends at once while it loads a scene for a minute, its own or a client's") {
  {
    ServerProcess server({}, kEndless);
    std::this_thread::sleep_for(300ms);  // it loads; ending before is as good
    server.process().send_signal(SIGTERM);
    CHECK(server.process().wait(kAtOnce) == kEnded);
  }
  for (const int signal : {SIGTERM, SIGHUP, 0}) {
    ServerProcess server({"--scenes", "."});
    client::CommandLink commands(server.commands());
    commands.hello(kPatience);
    CHECK_THROWS_AS(commands.load_text(kEndless, 300ms), client::Vanished);
    if (signal != 0)
      server.process().send_signal(signal);
    else
      client::CommandLink(server.commands()).shutdown(kPatience);
    CHECK(server.process().wait(kAtOnce) == kEnded);
  }
}

TEST_CASE("SIGTERM ends a server with a subscriber that never reads") {
  ServerProcess server;
  client::StateLink stalled(server.states(), 1);
  stalled.subscribe("");
  wait_until_up(server);
  server.process().send_signal(SIGTERM);
  CHECK(server.process().wait(kPatience) == kEnded);
}

TEST_CASE("SIGTERM ends a long step") {
  ServerProcess server({"--lockstep"});
  client::CommandLink commands(server.commands());
  commands.hello(kPatience);
  CHECK_THROWS_AS(commands.step(protocol::kMaxStepTicks, 1ms), client::Vanished);
  server.process().send_signal(SIGTERM);
  CHECK(server.process().wait(kPatience) == kEnded);
}

TEST_CASE("shutdown is answered, then the server ends with status 0") {
  for (const std::vector<std::string>& options : {std::vector<std::string>{}, {"--lockstep"}}) {
    ServerProcess server(options);
    client::CommandLink(server.commands()).shutdown(kPatience);
    CHECK(server.process().wait(kPatience) == kEnded);
  }
}

TEST_CASE("--ticks ends the server by itself") {
  ServerProcess server({"--ticks", "50"});
  CHECK(server.process().wait(kPatience) == kEnded);

  ServerProcess lockstep({"--lockstep", "--ticks", "50"});
  CHECK(client::CommandLink(lockstep.commands()).step(100, kPatience).tick == 50);
  CHECK(lockstep.process().wait(kPatience) == kEnded);
}

TEST_CASE("--check loads the scene and ends") {
  ServerProcess server({"--check"});
  CHECK(server.process().wait(kPatience) == kEnded);
}

TEST_CASE("what cannot start says so in its exit status") {
  ServerProcess running;
  wait_until_up(running);

  Process without_scene({program_path("acus-server")});
  CHECK(without_scene.wait(kPatience) == kBadCommandLine);
  Process absent_scene({program_path("acus-server"), running.folder() / "absent.yaml"});
  CHECK(absent_scene.wait(kPatience) == kBadScene);
  Process bad_endpoint({program_path("acus-server"), running.scene(), "--commands", "nonsense"});
  CHECK(bad_endpoint.wait(kPatience) == kBadCommandLine);
}

TEST_CASE("a client may start before the server") {
  ServerProcess none({"--check"});
  REQUIRE(none.process().wait(kPatience) == kEnded);
  client::CommandLink commands(none.commands());
  CHECK_THROWS_AS(commands.hello(200ms), client::Vanished);
  Process late(none.command_line({}));
  CHECK(commands.hello(kPatience).scene == "small");
}

TEST_CASE("a client notices that the server was killed, and finds the next one") {
  ServerProcess server;
  client::CommandLink commands(server.commands());
  commands.hello(kPatience);
  server.process().send_signal(SIGKILL);
  CHECK(server.process().wait(kPatience) == -SIGKILL);
  CHECK_THROWS_AS(commands.hello(500ms), client::Vanished);
  Process next(server.command_line({}));
  CHECK(commands.hello(kPatience).scene == "small");
}

}  // namespace acus::testing
