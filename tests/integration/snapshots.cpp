// SPDX-License-Identifier: GPL-3.0-or-later
// Snapshots over the wire: branches in one server, the same run in a second one, and what no server goes on from.
#include <doctest/doctest.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <thread>

#include "tests/integration/server_process.h"
#include "tests/support/file_content.h"

namespace acus::testing {
namespace {

// Pushes the needle `ticks` ticks further, with a pose for each.
void push(client::CommandLink& commands, std::uint64_t from, std::uint64_t ticks) {
  commands.acquire({"needle"}, kPatience);
  for (std::uint64_t i = from + 1; i <= from + ticks; ++i) {
    REQUIRE(commands.send(pose_at(0.5 - 1e-4 * static_cast<double>(i), i)));
    commands.step(1, kPatience);
  }
}

std::string refusal(client::CommandLink& commands, const std::vector<std::uint8_t>& snapshot) {
  try {
    commands.restore(snapshot, kPatience);
    return "accepted";
  } catch (const client::Refused& refused) {
    return name_of(refused.error.code);
  }
}

// Memory of a process, in kB.
long resident(const Process& process) {
  std::ifstream status("/proc/" + std::to_string(process.id()) + "/status");
  for (std::string word; status >> word;) {
    long kilobytes = 0;
    if (word == "VmRSS:" && status >> kilobytes) return kilobytes;
  }
  return 0;
}

}  // namespace

// What a planner does.
TEST_CASE("a thousand branches of twenty ticks end alike and leave nothing behind") {
  ServerProcess server({"--lockstep"});
  client::CommandLink commands(server.commands());
  push(commands, 0, 5);
  const protocol::SnapshotReply start = commands.snapshot(kPatience);
  std::uint64_t end = 0;
  long settled = 0;
  const auto begun = std::chrono::steady_clock::now();
  for (int branch = 0; branch < 1000; ++branch) {
    commands.restore(start.snapshot, kPatience);
    REQUIRE(commands.send(pose_at(0.45, 100)));
    commands.step(20, kPatience);
    if (branch == 200) settled = resident(server.process());
    if (branch % 100 != 0) continue;
    const std::uint64_t hash = commands.hash(kPatience).hash;
    if (branch == 0) end = hash;
    CHECK(hash == end);
  }
  const std::chrono::duration<double, std::milli> taken = std::chrono::steady_clock::now() - begun;
  MESSAGE("a branch takes ", taken.count() / 1000, " ms, its snapshot ", start.snapshot.size(), " bytes");
  REQUIRE(settled > 0);
#ifndef __SANITIZE_ADDRESS__  // which keeps what was freed
  CHECK(resident(server.process()) < settled + 2000);
#endif
}

TEST_CASE("a run branches from a snapshot, and a second server goes on alike") {
  ServerProcess server({"--lockstep"});
  client::CommandLink commands(server.commands());
  commands.hello(kPatience);
  push(commands, 0, 30);
  const protocol::SnapshotReply snapshot = commands.snapshot(kPatience);
  CHECK(snapshot.tick == 30);
  CHECK(snapshot.hash == commands.hash(kPatience).hash);
  push(commands, 30, 20);
  const std::uint64_t end = commands.hash(kPatience).hash;
  CHECK(end != snapshot.hash);

  const protocol::Done back = commands.restore(snapshot.snapshot, kPatience);
  CHECK(back.tick == 30);
  CHECK(back.epoch == snapshot.epoch + 1);
  CHECK(commands.hash(kPatience).hash == snapshot.hash);
  push(commands, 30, 20);
  CHECK(commands.hash(kPatience).hash == end);

  ServerProcess second({"--lockstep"});
  client::CommandLink others(second.commands());
  others.restore(snapshot.snapshot, kPatience);
  push(others, 30, 20);
  CHECK(others.hash(kPatience).hash == end);

  const std::string file = second.folder() / "snapshot";
  std::ofstream(file, std::ios::binary)
      .write(reinterpret_cast<const char*>(snapshot.snapshot.data()),
             static_cast<std::streamsize>(snapshot.snapshot.size()));
  ServerProcess third({"--lockstep", "--restore", file});
  client::CommandLink again(third.commands());
  CHECK(again.hash(kPatience).tick == 30);
  push(again, 30, 20);
  CHECK(again.hash(kPatience).hash == end);
}

TEST_CASE("in real time a server goes on from a snapshot, and its states say so") {
  ServerProcess server;
  client::CommandLink commands(server.commands());
  client::StateLink states = subscribe(server, {"force"});
  const protocol::SnapshotReply snapshot = commands.snapshot(kPatience);
  receive<protocol::Force>(states);
  const protocol::Done done = commands.restore(snapshot.snapshot, kPatience);
  CHECK(done.tick == snapshot.tick);
  protocol::Force force;
  do force = receive<protocol::Force>(states);
  while (force.epoch != done.epoch);
  CHECK(force.tick == snapshot.tick + 1);
}

TEST_CASE("a snapshot that is damaged or of another scene is refused, and nothing changes") {
  ServerProcess server({"--lockstep"}), other({"--lockstep"}, small_scene("other", {"needle", "second"}));
  client::CommandLink commands(server.commands()), others(other.commands());
  const protocol::SnapshotReply snapshot = commands.snapshot(kPatience);
  CHECK(refusal(others, snapshot.snapshot) == "snapshot_error");
  std::vector<std::uint8_t> damaged = snapshot.snapshot;
  damaged[damaged.size() / 2] ^= 1;
  push(commands, 0, 3);
  const protocol::HashReply before = commands.hash(kPatience);
  CHECK(refusal(commands, damaged) == "snapshot_error");
  CHECK(refusal(commands, {}) == "snapshot_error");
  const protocol::HashReply after = commands.hash(kPatience);
  CHECK(after.hash == before.hash);
  CHECK(after.epoch == before.epoch);
}

TEST_CASE("stats tell the hash of every full second, the same in each run") {
  const auto hash_of_second = [] {
    ServerProcess server({"--lockstep"});
    client::CommandLink commands(server.commands());
    client::StateLink states = subscribe(server, {"stats"});
    commands.step(200, kPatience);
    for (;;) {
      const auto stats = receive<protocol::Stats>(states);
      if (stats.hash_tick == 200) return stats.hash;
    }
  };
  const std::uint64_t hash = hash_of_second();
  CHECK(hash != 0);
  CHECK(hash == hash_of_second());
}

// What is in a file, once it is there.
std::vector<std::uint8_t> wait_for_file(const std::string& file) {
  const auto deadline = std::chrono::steady_clock::now() + kPatience;
  while (!std::filesystem::exists(file) && std::chrono::steady_clock::now() < deadline)
    std::this_thread::sleep_for(10ms);
  const std::string bytes = content_of(file);
  return {bytes.begin(), bytes.end()};
}

TEST_CASE("a scene that asks for snapshots gets them into a file, from which a server that was killed goes on") {
  const TemporaryFolder folder;
  const std::string file = folder / "newest.snapshot", scene = small_scene("small") + "publish: {snapshot_every: 1}\n";
  std::vector<std::uint8_t> snapshot;
  {
    ServerProcess server({"--lockstep", "--snapshot", file}, scene);
    client::CommandLink commands(server.commands());
    push(commands, 0, 199);
    CHECK(!std::filesystem::exists(file));
    push(commands, 199, 1);
    snapshot = wait_for_file(file);
    server.process().send_signal(SIGKILL);
    server.process().wait(kPatience);
  }
  CHECK(!std::filesystem::exists(file + ".new"));
  ServerProcess server({"--lockstep", "--restore", file}, scene), other({"--lockstep"}, scene);
  client::CommandLink commands(server.commands()), others(other.commands());
  CHECK(commands.hash(kPatience).tick == 200);
  others.restore(snapshot, kPatience);
  CHECK(others.hash(kPatience).hash == commands.hash(kPatience).hash);
}

TEST_CASE("a snapshot that is due is written without a client") {
  const TemporaryFolder folder;
  const std::string file = folder / "newest.snapshot";
  ServerProcess server({"--snapshot", file, "--ticks", "300"}, small_scene("small") + "publish: {snapshot_every: 1}\n");
  CHECK(server.process().wait(kPatience) == 0);  // half a second after it was due
  CHECK(std::filesystem::exists(file));
}

TEST_CASE("a snapshot that cannot be written leaves the one before, and the server goes on") {
  const TemporaryFolder folder;
  folder.write("newest.snapshot", "acussnap as it was");
  ServerProcess server({"--lockstep", "--snapshot", folder / "newest.snapshot"},
                       small_scene("small") + "publish: {snapshot_every: 1}\n");
  client::CommandLink commands(server.commands());
  commands.hello(kPatience);
  std::filesystem::create_directory(folder / "newest.snapshot.new");  // where it would be written
  for (int second = 0; second < 3; ++second) commands.step(200, kPatience);
  CHECK(commands.hash(kPatience).tick == 600);
  CHECK(content_of(folder / "newest.snapshot") == "acussnap as it was");
}

TEST_CASE("a pipe where a snapshot would be written holds nobody up, with a reader and without") {
  for (const bool read : {false, true}) {
    const TemporaryFolder folder;
    const std::string pipe = folder / "newest.snapshot.new";
    ServerProcess server({"--lockstep", "--snapshot", folder / "newest.snapshot"},
                         small_scene("small") + "publish: {snapshot_every: 1}\n");
    client::CommandLink commands(server.commands());
    commands.hello(kPatience);
    REQUIRE(mkfifo(pipe.c_str(), 0600) == 0);
    const int reader = read ? open(pipe.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC) : -1;
    for (int second = 0; second < 3; ++second) commands.step(200, kPatience);
    server.process().send_signal(SIGTERM);
    CHECK(server.process().wait(kPatience) == 0);
    CHECK_FALSE(std::filesystem::exists(folder / "newest.snapshot"));
    if (reader >= 0) close(reader);
  }
}

TEST_CASE("what another program puts in the place of a snapshot meanwhile is not replaced") {
  const TemporaryFolder folder;
  ServerProcess server({"--lockstep", "--snapshot", folder / "newest.snapshot"},
                       small_scene("small") + "publish: {snapshot_every: 1}\n");
  client::CommandLink commands(server.commands());
  commands.hello(kPatience);
  folder.write("newest.snapshot", "as it was");
  for (int second = 0; second < 3; ++second) commands.step(200, kPatience);
  server.process().send_signal(SIGTERM);
  CHECK(server.process().wait(kPatience) == 0);
  CHECK(content_of(folder / "newest.snapshot") == "as it was");
}

TEST_CASE("two servers do not write one file of snapshots; the second does not start") {
  const TemporaryFolder folder, link;
  const std::string file = folder / "newest.snapshot";
  std::filesystem::create_directory_symlink(folder.path(), link / "link");
  ServerProcess first({"--lockstep", "--snapshot", file});
  client::CommandLink(first.commands()).hello(kPatience);
  ServerProcess second({"--lockstep", "--snapshot", link / "link/newest.snapshot"});
  CHECK(second.process().wait(kPatience) == 5);
  ServerProcess other({"--lockstep", "--snapshot", folder / "other.snapshot"});
  client::CommandLink(other.commands()).hello(kPatience);
  first.process().send_signal(SIGKILL);
  first.process().wait(kPatience);
  ServerProcess third({"--lockstep", "--snapshot", file});
  client::CommandLink(third.commands()).hello(kPatience);
  third.process().send_signal(SIGTERM);
  CHECK(third.process().wait(kPatience) == 0);
  CHECK_FALSE(std::filesystem::exists(file + ".lock"));
}

TEST_CASE("what is no file is not restored from") {
  CHECK(ServerProcess({"--restore", "/dev/zero"}).process().wait(kPatience) == 2);
}

}  // namespace acus::testing
