// SPDX-License-Identifier: GPL-3.0-or-later
// The hole that a tip has cut: a polyline of material points of the tissue. It moves with the tissue, outlives the
// needle and is found again at its mouth. Vertex 0 is the mouth on the surface, further vertices follow at the
// needle's constraint spacing, and `end` is where the cut stops (or where it leaves the tissue). A tissue remembers a
// fixed number of paths; when a needle needs another, the one that was left longest ago is forgotten.
//
// A needle that has come out of a folded or hollow tissue may go into it again: the path then has parts, with air between
// them. A part ends at a vertex in `exits`, and the next vertex is the mouth of the next part. A needle that is drawn out
// of the last part forgets it; so a path that was left has one part.
//
// Shaft rows act at its vertices, which are points of the tissue, not of the needle: so the path has no kink under the
// shaft, however the elements deform.
#pragma once

#include <algorithm>
#include <cstdint>
#include <utility>

#include "server/engine/math/bounded.h"
#include "server/engine/models/geometry/material_point.h"

namespace acus {

// Of a path, at most: a needle that comes out once more meets surfaces that it cannot puncture.
inline constexpr int kMaxGaps = 4;

struct Path {
  Bounded<MaterialPoint> vertices;
  MaterialPoint end;
  double spacing = 0;      // m, between vertices: that of the needle which cut it first
  double head = 0;         // m, length of the cut from the mouth to the next vertex
  double tail = 0;         // m, from the last vertex to the end, as it was when it was cut
  bool exited = false;     // the end is a second mouth
  Bounded<int> exits;      // vertices with air behind them, ascending
  int needle = -1;         // the needle that is in it, -1 if none
  std::uint64_t left = 0;  // tick in which the last needle left it

  Path() = default;
  explicit Path(int capacity) : vertices(static_cast<std::size_t>(capacity)), exits(kMaxGaps) {}

  bool empty() const { return vertices.empty(); }
  int points() const { return empty() ? 0 : static_cast<int>(vertices.size()) + 1; }
  const MaterialPoint& point(int i) const {
    assert(i >= 0 && i < points());
    return i + 1 < points() ? vertices[static_cast<std::size_t>(i)] : end;
  }

  // A new path that is nothing but its mouth.
  void begin(const MaterialPoint& mouth, double vertex_spacing) {
    vertices.clear();
    vertices.push_back(mouth);
    end = mouth;
    spacing = head = vertex_spacing;
    tail = 0;
    exited = false;
    exits.clear();
  }

  // The vertex at which its last part begins.
  int last_mouth() const { return exits.empty() ? 0 : exits.back() + 1; }
  bool air_behind(int vertex) const { return std::find(exits.begin(), exits.end(), vertex) != exits.end(); }
  bool has_room_for_part() const { return !exits.full() && vertices.size() + 2 <= vertices.capacity(); }

  // Of a path that has left the tissue: it continues as a mouth further on.
  void add_part(const MaterialPoint& mouth) {
    assert(exited && has_room_for_part());
    exits.push_back(static_cast<int>(vertices.size()));
    vertices.push_back(end);
    vertices.push_back(mouth);
    end = mouth;
    tail = 0;
    exited = false;
  }
  // Its last part is nothing but its mouth again.
  void shorten_to_mouth() {
    vertices.resize(static_cast<std::size_t>(last_mouth()) + 1);
    end = vertices.back();
    tail = 0;
    exited = false;
  }
  // The last part is forgotten; `cut` (m) is what the one before has between its last vertex and its end.
  void drop_part(double cut) {
    assert(!exits.empty());
    vertices.resize(static_cast<std::size_t>(last_mouth()));
    end = vertices.back();
    vertices.pop_back();
    exits.pop_back();
    tail = cut;
    exited = true;
  }

  // A path that is open at both ends, seen from the other end.
  void turn_round() {
    assert(exited && !empty() && exits.empty());
    std::reverse(vertices.begin(), vertices.end());  // the mouth is last
    std::swap(vertices.back(), end);                 // and becomes the end; the old end stands in its place
    std::rotate(vertices.begin(), vertices.end() - 1, vertices.end());
    if (vertices.size() > 1) std::swap(head, tail);
  }

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("vertices", self.vertices);
    visit("end", self.end);
    visit("spacing", self.spacing);
    visit("head", self.head);
    visit("tail", self.tail);
    visit("exited", self.exited);
    visit("exits", self.exits);
    visit("needle", self.needle);
    visit("left", self.left);
  }
};

}  // namespace acus
