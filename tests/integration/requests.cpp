// SPDX-License-Identifier: GPL-3.0-or-later
// Each request does what the contract says.
#include <doctest/doctest.h>

#include <filesystem>
#include <functional>
#include <thread>

#include "tests/integration/server_process.h"

namespace acus::testing {
namespace {

// The code with which the server refuses what `ask` asks for.
template <class Ask>
std::string refusal(Ask&& ask) {
  try {
    ask();
    return "accepted";
  } catch (const client::Refused& refused) {
    return name_of(refused.error.code);
  }
}

}  // namespace

TEST_CASE("hello and describe tell the same scene") {
  ServerProcess server;
  client::CommandLink commands(server.commands());
  const protocol::HelloReply hello = commands.hello(kPatience);
  CHECK(hello.scene == "small");
  CHECK(hello.rate == 200);
  CHECK(hello.time_step == doctest::Approx(1.0 / 200));
  CHECK_FALSE(hello.lockstep);
  REQUIRE(hello.needles.size() == 1);
  CHECK(hello.needles[0].name == "needle");
  CHECK(hello.needles[0].nodes == 6);
  CHECK(hello.needles[0].base_position == protocol::Vector3{0, 0, 0.5});
  CHECK(hello.topics.size() == 6);

  const protocol::DescribeReply describe = commands.describe(kPatience);
  CHECK(describe.positions.size() == 3 * hello.tissue.nodes);
  CHECK(describe.triangles.size() == 3 * hello.tissue.triangles);
  CHECK(describe.tetrahedra.size() == 4 * hello.tissue.tetrahedra);
  CHECK(describe.tetrahedron_regions.size() == hello.tissue.tetrahedra);
  REQUIRE(describe.needles.size() == 1);
  CHECK(describe.needles[0].positions.size() == 3 * hello.needles[0].nodes);
}

TEST_CASE("pause stops simulation time and resume goes on") {
  ServerProcess server;
  client::CommandLink commands(server.commands());
  const protocol::Done paused = commands.pause(kPatience);
  std::this_thread::sleep_for(100ms);
  CHECK(commands.hello(kPatience).paused);
  const protocol::Done resumed = commands.resume(kPatience);
  CHECK(resumed.tick == paused.tick);
  CHECK_FALSE(commands.hello(kPatience).paused);
  client::StateLink states = subscribe(server, {"force"});
  CHECK(receive<protocol::Force>(states).tick > resumed.tick);
}

TEST_CASE("reset begins a new epoch at tick 0, and forgets the commands given before") {
  ServerProcess server;
  client::CommandLink commands = hold(server);
  client::StateLink states = subscribe(server, {"force"});
  REQUIRE(commands.send(pose_at(0.5, 7)));
  while (receive<protocol::Force>(states).seq != 7) {
  }
  const protocol::Done reset = commands.reset(kPatience);
  CHECK(reset.epoch == 1);
  CHECK(reset.tick == 0);
  protocol::Force force = receive<protocol::Force>(states);
  while (force.epoch == 0) force = receive<protocol::Force>(states);
  CHECK(force.tick == 1);
  CHECK(force.seq == 0);
}

TEST_CASE("load swaps the scene, and a scene that cannot be used changes nothing") {
  ServerProcess server;
  client::CommandLink commands(server.commands());
  const std::string bad = server.folder().write("bad.yaml", small_scene("bad") + "nonsense: 1\n");
  CHECK(refusal([&] { commands.load(bad, kPatience); }) == "scene_error");
  CHECK(refusal([&] { commands.load(server.folder() / "absent.yaml", kPatience); }) == "scene_error");
  CHECK(commands.hello(kPatience).scene == "small");
  CHECK(commands.hello(kPatience).epoch == 0);

  const std::string good = server.folder().write("good.yaml", small_scene("pair", {"left", "right"}));
  const protocol::Done loaded = commands.load(good, kPatience);
  CHECK(loaded.epoch == 1);
  CHECK(loaded.tick == 0);
  CHECK(commands.hello(kPatience).scene == "pair");
  CHECK(commands.hello(kPatience).needles.size() == 2);

  client::StateLink states = subscribe(server, {"force"});
  commands.acquire({"right"}, kPatience);
  REQUIRE(commands.send(pose_at(0.5, 9, "right")));
  protocol::Force force = receive<protocol::Force>(states);
  while (force.seq != 9) force = receive<protocol::Force>(states);
  CHECK(force.needle == "right");
}

TEST_CASE("a scene comes as text, too, and nothing outside the server's scene folders is read") {
  ServerProcess server;
  client::CommandLink commands(server.commands());
  CHECK(commands.load_text(small_scene("from text", {"a", "b"}), kPatience).epoch == 1);
  CHECK(commands.hello(kPatience).scene == "from text");
  CHECK(refusal([&] { commands.load_text("acus_scene: 1\nnonsense: 1\n", kPatience); }) == "scene_error");
  CHECK(refusal([&] { commands.load_text("", kPatience); }) == "bad_value");

  const TemporaryFolder elsewhere;
  const std::string outside = elsewhere.write("outside.yaml", small_scene("outside"));
  const auto why = [&](const std::function<void()>& request) -> std::string {
    try {
      request();
      return "";
    } catch (const client::Refused& refused) {
      return refused.error.message;
    }
  };
  const std::string expected = "expected a file in the folders that clients may load from";
  for (const std::string& file : {outside, elsewhere / "absent.yaml", std::string("/etc/passwd")})
    CHECK(why([&] { commands.load(file, kPatience); }).find(expected) != std::string::npos);
  const std::string link = server.folder() / "link.yaml";
  std::filesystem::create_symlink(outside, link);
  CHECK(why([&] { commands.load(link, kPatience); }).find(expected) != std::string::npos);
  std::string with_mesh = small_scene("mesh");
  const std::string box = "    box: {size: [0.1, 0.1, 0.1], cells: [3, 3, 3]}\n";
  with_mesh.replace(with_mesh.find(box), box.size(), "    gmsh: {file: /etc/passwd, metres_per_unit: 1}\n");
  CHECK(why([&] { commands.load_text(with_mesh, kPatience); }).find(expected) != std::string::npos);
  CHECK(commands.hello(kPatience).scene == "from text");

  ServerProcess open({"--scenes", elsewhere.path()});
  client::CommandLink allowed(open.commands());
  allowed.load(outside, kPatience);
  CHECK(allowed.hello(kPatience).scene == "outside");
  CHECK(refusal([&] { allowed.load(open.scene(), kPatience); }) == "scene_error");
}

TEST_CASE("loading again and again, under load, harms nothing") {
  ServerProcess server;
  client::CommandLink commands = hold(server);
  client::StateLink states = subscribe(server, {"force", "needle", "tissue", "event"});
  const std::string pair = server.folder().write("pair.yaml", small_scene("pair", {"left", "needle"}));
  for (int i = 0; i < 10; ++i) {
    commands.acquire({"needle"}, kPatience);
    for (int k = 0; k < 20; ++k) CHECK(commands.send(pose_at(0.5, 1 + k)));
    CHECK(commands.load(i % 2 == 0 ? pair : server.scene(), kPatience).epoch == static_cast<std::uint64_t>(i + 1));
  }
  protocol::Force force = receive<protocol::Force>(states);
  while (force.epoch < 10) force = receive<protocol::Force>(states);
  CHECK(force.needle == "needle");
}

TEST_CASE("step is refused in real time, pause and resume in lockstep") {
  ServerProcess real_time, lockstep({"--lockstep"});
  client::CommandLink to_real_time(real_time.commands()), to_lockstep(lockstep.commands());
  CHECK(refusal([&] { to_real_time.step(1, kPatience); }) == "wrong_mode");
  CHECK(refusal([&] { to_lockstep.pause(kPatience); }) == "wrong_mode");
  CHECK(refusal([&] { to_lockstep.resume(kPatience); }) == "wrong_mode");
}

}  // namespace acus::testing
