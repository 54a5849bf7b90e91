// SPDX-License-Identifier: GPL-3.0-or-later
// A block of 64 nodes and a needle of six nodes half a millimetre above it, for runs that must be short.
#pragma once

#include "server/engine/scene/scene.h"

namespace acus::test {

inline Scene small_block() {
  return parse_scene(R"(acus_scene: 1
rate: 500
tissue:
  mesh:
    box: {size: [0.1, 0.1, 0.1], cells: [3, 3, 3]}
  fixed:
    - box: {max: [.inf, .inf, -0.04]}
needles:
  - name: needle
    length: 0.1
    beams: 5
    base: {position: [0.003, 0.002, 0.1505], orientation: [0.7071067811865476, 0, 0.7071067811865476, 0]}
)",
                     "small.yaml");
}

}  // namespace acus::test
