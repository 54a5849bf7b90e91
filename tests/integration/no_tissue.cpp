// SPDX-License-Identifier: GPL-3.0-or-later
// A scene without tissue: what clients see instead of one.
#include <doctest/doctest.h>

#include "tests/integration/server_process.h"

namespace acus::testing {

TEST_CASE("a scene without tissue has a tissue without nodes, and its needles move") {
  ServerProcess server({"--lockstep"},
                       "acus_scene: 1\nname: alone\ntissue: {rung: none}\n"
                       "needles: [{beams: 5, base: {position: [0, 0, 0.5]}}]\n");
  client::CommandLink commands = hold(server);
  const protocol::HelloReply hello = commands.hello(kPatience);
  CHECK(hello.tissue.nodes == 0);
  CHECK(hello.tissue.tetrahedra == 0);
  CHECK(hello.tissue.triangles == 0);
  const protocol::DescribeReply described = commands.describe(kPatience);
  CHECK(described.positions.empty());
  CHECK(described.regions.empty());
  CHECK(described.needles[0].positions.size() == 18);

  client::StateLink forces = subscribe(server, {"force"});
  client::StateLink shapes = subscribe(server, {"tissue"});
  REQUIRE(commands.send(pose_at(0.4, 1)));
  const std::uint64_t end = commands.step(300, kPatience).tick;
  CHECK(receive<protocol::TissueShape>(shapes).positions.empty());
  protocol::Force force = receive<protocol::Force>(forces);
  while (force.tick < end) force = receive<protocol::Force>(forces);
  CHECK(force.seq == 1);
  CHECK(force.base_position[2] == doctest::Approx(0.4).epsilon(5e-6).scale(0));
  CHECK(force.depth == 0);
}

}  // namespace acus::testing
