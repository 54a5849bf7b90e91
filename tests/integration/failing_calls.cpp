// SPDX-License-Identifier: GPL-3.0-or-later
// A server whose system refuses something once, or has no more threads or memory, says so and goes on.
#include <doctest/doctest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <thread>

#include "tests/integration/server_process.h"
#include "tests/support/mesh_files.h"
#include "tests/support/places.h"

namespace acus::testing {
namespace {

using client::CommandLink;

struct Asked {
  const char* name;
  std::function<void(CommandLink&)> ask;
};

constexpr const char* kMeshScene = R"(acus_scene: 1
name: mesh
rate: 200
tissue:
  mesh: {gmsh: {file: b.msh}}
  fixed:
    - box: {max: [.inf, .inf, 0.5]}
needles:
  - {name: needle, length: 0.1, beams: 5, base: {position: [0, 0, 5]}}
)";

// Of a scene with enough nodes that states take pages.
std::string larger_scene() {
  std::string scene = small_scene("larger");
  const std::string cells = "cells: [3, 3, 3]";
  return scene.replace(scene.find(cells), cells.size(), "cells: [7, 7, 7]");
}

// Bytes of addresses that a process uses.
std::uint64_t memory_of(pid_t process) {
  std::ifstream file("/proc/" + std::to_string(process) + "/statm");
  std::uint64_t pages = 0;
  file >> pages;
  return pages * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
}

// What it was refused with; "" if nothing was.
std::string refusal(CommandLink& commands, const Asked& asked) {
  try {
    asked.ask(commands);
    return "";
  } catch (const client::Refused& error) {
    return error.what();
  }
}

}  // namespace

TEST_CASE("each call of the system fails once in each request: the server goes on, and does the next one") {
  const TemporaryFolder folder, failing, recordings;
  const std::string scene = larger_scene() + "publish: {snapshot_every: 1}\n",
                    mesh = folder.write("mesh.yaml", kMeshScene);
  folder.write(test::kMsh2.name, test::kMsh2.text);
  ServerProcess server(
      {"--lockstep", "--recordings", recordings.path(), "--scenes", folder.path(), "--snapshot", folder / "newest"},
      scene,
      {"/usr/bin/env", "LD_PRELOAD=" + program_path("libacus_failing_calls.so"),
       "ACUS_FAILING_CALLS=" + failing.path()});
  CommandLink commands(server.commands());
  commands.hello(kPatience);
  const std::vector<std::uint8_t> snapshot = commands.snapshot(kPatience).snapshot;
  int recorded = 0;
  std::string armed;
  const auto step = [&](CommandLink& link) {  // until the snapshot that is due then is there, or its call has failed
    std::filesystem::remove(folder / "newest");
    link.step(200, kPatience);
    const auto deadline = std::chrono::steady_clock::now() + kPatience;
    while (!std::filesystem::exists(folder / "newest") && std::filesystem::exists(armed)) {
      REQUIRE(std::chrono::steady_clock::now() < deadline);
      std::this_thread::sleep_for(1ms);
    }
  };
  const std::vector<Asked> requests{
      {"hello", [](CommandLink& link) { link.hello(kPatience); }},
      {"describe", [](CommandLink& link) { link.describe(kPatience); }},
      {"acquire", [](CommandLink& link) { link.acquire({"needle"}, kPatience); }},
      {"step to a snapshot", step},
      {"hash", [](CommandLink& link) { link.hash(kPatience); }},
      {"snapshot", [](CommandLink& link) { link.snapshot(kPatience); }},
      {"restore", [&](CommandLink& link) { link.restore(snapshot, kPatience); }},
      {"reset", [](CommandLink& link) { link.reset(kPatience); }},
      {"record", [&](CommandLink& link) { link.record("run" + std::to_string(++recorded), kPatience); }},
      {"step to a snapshot", step},
      {"reset", [](CommandLink& link) { link.reset(kPatience); }},
      {"end of the recording", [](CommandLink& link) { link.end_recording(kPatience); }},
      {"load of a mesh", [&](CommandLink& link) { link.load(mesh, kPatience); }},
      {"load", [&](CommandLink& link) { link.load_text(scene, kPatience); }},
  };
  for (const char* call : {"thread", "fork", "mmap", "open", "write", "fsync"}) {
    int failed = 0;
    for (const Asked& asked : requests) {
      CAPTURE(call);
      CAPTURE(asked.name);
      armed = failing.write(call, "");
      const std::string told = refusal(commands, asked);
      failed += std::filesystem::remove(armed) ? 0 : 1;
      CAPTURE(told);
      commands.step(1, kPatience);
      CHECK_FALSE(commands.hello(kPatience).scene.empty());
    }
    MESSAGE(std::string(call) << " failed in " << failed << " of " << requests.size() << " requests");
    CHECK(failed > 0);
  }
}

// As `ulimit -v` of where it is, and some more: a load finds no thread, or its memory ends anywhere.
TEST_CASE("a load at the limit of memory is refused, and the old scene goes on") {
  ServerProcess server({"--lockstep"});
  CommandLink commands(server.commands());
  commands.hello(kPatience);
  const pid_t process = server.process().id();
  const std::uint64_t used = memory_of(process);
  int loaded = 0, refused = 0;
  for (std::uint64_t more = 0; more <= std::uint64_t{48} << 20; more += std::uint64_t{6} << 20) {
    CAPTURE(more);
    const rlimit limit{used + more, RLIM_INFINITY};
    REQUIRE(prlimit(process, RLIMIT_AS, &limit, nullptr) == 0);
    const std::string told =
        refusal(commands, {"load", [](CommandLink& link) { link.load_text(larger_scene(), kPatience); }});
    CAPTURE(told);
    ++(told.empty() ? loaded : refused);
    const bool says_why =
        told.empty() || told.find("memory") != std::string::npos || told.find("thread") != std::string::npos;
    CHECK(says_why);
    commands.step(1, kPatience);
  }
  CHECK(refused > 0);
}

}  // namespace acus::testing
