// SPDX-License-Identifier: GPL-3.0-or-later
// The hole that a tip has cut: a polyline of material points of the tissue. It moves with the tissue, outlives the
// needle and is found again at its mouth. Vertex 0 is the mouth on the surface, further vertices follow at the
// needle's constraint spacing, and `end` is where the cut stops (or where it leaves the tissue). A tissue remembers a
// fixed number of paths; when a needle needs another, the one that was left longest ago is forgotten.
#pragma once

#include <cstdint>
#include <vector>

#include "server/models/tissue_motion.h"

namespace acus {

struct Path {
  std::vector<MaterialPoint> vertices;  // capacity reserved at load
  MaterialPoint end;
  double spacing = 0;    // m, between vertices: that of the needle which cut it first
  double tail = 0;       // m, length of the cut from the last vertex to the end, as it was when it was cut
  bool exited = false;   // the end is a second mouth
  int needle = -1;       // the needle that is in it, -1 if none
  std::uint64_t left = 0;  // tick in which the last needle left it

  bool empty() const { return vertices.empty(); }
};

}  // namespace acus
