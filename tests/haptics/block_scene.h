// SPDX-License-Identifier: GPL-3.0-or-later
// A block of 64 nodes below a needle that points down, as YAML for acus-server.
#pragma once

#include <string>

namespace acus::testing {

// `region`: its only one, as a map of YAML; `base_height`: m, of the base; the tip touches at 0.15.
inline std::string block_scene(const std::string& region, double base_height, int rate) {
  return R"(acus_scene: 1
name: block
rate: )" +
         std::to_string(rate) +
         R"(
tissue:
  mesh:
    box: {size: [0.1, 0.1, 0.1], cells: [3, 3, 3]}
  regions: [)" +
         region + R"(]
  fixed:
    - box: {max: [.inf, .inf, -0.04]}
needles:
  - length: 0.1
    beams: 5
    base: {position: [0.003, 0.002, )" +
         std::to_string(base_height) + R"(], orientation: [0.7071067811865476, 0, 0.7071067811865476, 0]}
)";
}

}  // namespace acus::testing
