// SPDX-License-Identifier: GPL-3.0-or-later
// A guided needle goes into a tissue of two regions: what clients hear of regions, paths and guides.
#include <doctest/doctest.h>

#include <cmath>

#include "tests/integration/server_process.h"

namespace acus::testing {
namespace {

constexpr const char* kScene = R"(acus_scene: 1
name: guided
rate: 200
tissue:
  mesh:
    box: {size: [0.1, 0.1, 0.1], cells: [4, 4, 4]}
  regions:
    - name: core
    - name: crust
      half_space: {point: [0, 0, 0.025], normal: [0, 0, -1]}
      interaction: {puncture_force: 0.5, cutting_force: 0.3}
  fixed:
    - box: {max: [.inf, .inf, -0.05]}
needles:
  - name: probe
    length: 0.1
    beams: 10
    base: {position: [0.003, 0.002, 0.16], orientation: [0.70710678, 0, 0.70710678, 0]}
guides:
  - name: collar
    needle: probe
    pose: {position: [0.003, 0.002, 0.08], orientation: [0.70710678, 0, 0.70710678, 0]}
)";

constexpr double kHalfRoot = 0.70710678;

protocol::Pose pose_down(const std::string& body, double x, double height, std::uint64_t seq) {
  protocol::Pose pose;
  pose.needle = body;
  pose.seq = seq;
  pose.position = {x, 0.002, height};
  pose.orientation = {kHalfRoot, 0, kHalfRoot, 0};
  return pose;
}

// A server in lockstep with the scene above.
struct Bench {
  Bench() {
    commands.load(server.folder().write("guided.yaml", kScene), kPatience);
    commands.acquire({"probe", "collar"}, kPatience);
  }

  // Pushes the needle by 40 mm at 20 mm/s.
  void insert() {
    for (std::uint64_t i = 1; i <= 40; ++i) {
      REQUIRE(commands.send(pose_down("probe", 0.003, 0.16 - 1e-3 * static_cast<double>(i), i)));
      commands.step(10, kPatience);
    }
  }

  protocol::Force force_at(client::StateLink& states, const protocol::Done& done) const {
    protocol::Force force = receive<protocol::Force>(states);
    while (force.tick < done.tick) force = receive<protocol::Force>(states);
    return force;
  }

  std::string rejection() {
    commands.hello(kPatience);  // answered after what came before it
    const std::optional<protocol::Error> error = commands.next_rejection();
    return error ? name_of(error->code) : "none";
  }

  ServerProcess server{{"--lockstep"}};
  client::CommandLink commands{server.commands()};
};

}  // namespace

TEST_CASE("hello lists the guides, where they were loaded") {
  Bench bench;
  const protocol::HelloReply hello = bench.commands.hello(kPatience);
  REQUIRE(hello.guides.size() == 1);
  CHECK(hello.guides[0].name == "collar");
  CHECK(hello.guides[0].needle == "probe");
  CHECK(hello.guides[0].position == protocol::Vector3{0.003, 0.002, 0.08});
  CHECK(hello.guides[0].orientation.w == doctest::Approx(kHalfRoot));
}

TEST_CASE("events name the region that the tip meets, and the tissue's state holds the path that it cuts") {
  Bench bench;
  client::StateLink events = subscribe(bench.server, {"event"});
  client::StateLink shapes = subscribe(bench.server, {"tissue"});
  bench.insert();

  const auto contact = receive<protocol::Event>(events);
  CHECK(contact.kind == protocol::EventKind::contact);
  CHECK(contact.region == "crust");
  const auto puncture = receive<protocol::Event>(events);
  CHECK(puncture.kind == protocol::EventKind::puncture);
  CHECK(puncture.region == "crust");
  CHECK(puncture.force == doctest::Approx(0.5).epsilon(5e-6).scale(0));
  const auto border = receive<protocol::Event>(events);
  CHECK(border.kind == protocol::EventKind::contact);
  CHECK(border.region == "core");

  auto tissue = receive<protocol::TissueShape>(shapes);
  CHECK(tissue.path_points.empty());
  CHECK(tissue.path_sizes.empty());
  while (tissue.time < 1.9) tissue = receive<protocol::TissueShape>(shapes);
  REQUIRE(tissue.path_sizes.size() == 1);
  REQUIRE(tissue.path_sizes[0] > 2);
  REQUIRE(tissue.path_points.size() == 3 * static_cast<std::size_t>(tissue.path_sizes[0]));
  CHECK(tissue.path_points[2] == doctest::Approx(0.05).epsilon(0.08).scale(0));  // the mouth
  CHECK(tissue.path_points.back() < tissue.path_points[2]);            // and down from there
  CHECK(std::abs(tissue.path_points[0] - 0.003) < 2e-4);
}

TEST_CASE("a pose moves a guide, which then bends the needle in it") {
  Bench bench;
  client::StateLink states = subscribe(bench.server, {"force"});
  const protocol::Force before = bench.force_at(states, bench.commands.step(10, kPatience));
  REQUIRE(bench.commands.send(pose_down("collar", 0.005, 0.08, 1)));
  const protocol::Force after = bench.force_at(states, bench.commands.step(200, kPatience));
  CHECK(bench.rejection() == "none");
  CHECK(std::abs(before.guide_force[0]) < 1e-9);
  CHECK(after.guide_force[0] > 0.01);
  CHECK(after.tip_position[0] > before.tip_position[0] + 0.002);

  // The needle still takes its own commands.
  REQUIRE(bench.commands.send(pose_down("probe", 0.003, 0.159, 1)));
  const protocol::Force moved = bench.force_at(states, bench.commands.step(100, kPatience));
  CHECK(moved.seq == 1);
  CHECK(moved.base_position[2] == doctest::Approx(0.159).epsilon(5e-6).scale(0));
}

TEST_CASE("a guide takes no spin, and names nothing that the scene does not have") {
  Bench bench;
  protocol::Pose spun = pose_down("collar", 0.003, 0.08, 1);
  spun.spin = 0.0;
  REQUIRE(bench.commands.send(spun));
  CHECK(bench.rejection() == "bad_value");
  REQUIRE(bench.commands.send(protocol::Spin{"collar", 2, 0, 1.0}));
  CHECK(bench.rejection() == "bad_value");
  REQUIRE(bench.commands.send(pose_down("colar", 0.003, 0.08, 3)));
  CHECK(bench.rejection() == "unknown_needle");
  REQUIRE(bench.commands.send(pose_down("collar", 0.003, 0.08, 4)));
  CHECK(bench.rejection() == "none");
}

}  // namespace acus::testing
