// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/benchmarks/small_scene.h"

namespace acus::test {

Scene small_scene() {
  return parse_scene(
      "acus_scene: 1\n"
      "name: small\n"
      "tissue:\n"
      "  mesh: {box: {size: [0.06, 0.06, 0.06], cells: [3, 3, 3]}}\n"
      "  fixed: [{box: {max: [.inf, .inf, -0.03]}}]\n"
      "needles:\n"
      "  - beams: 5\n"
      "    length: 0.1\n"
      "    base: {position: [0.003, 0.002, 0.132], orientation: [0.7071068, 0, 0.7071068, 0]}\n",
      "small.yaml", ".");
}

client::Trajectory small_push() {
  return client::parse_trajectory(
      "t,needle,x,y,z,qw,qx,qy,qz\n"
      "2,needle,0.003,0.002,0.132,0.7071068,0,0.7071068,0\n"
      "2.125,needle,0.003,0.002,0.120,0.7071068,0,0.7071068,0\n",
      "push.csv");
}

}  // namespace acus::test
