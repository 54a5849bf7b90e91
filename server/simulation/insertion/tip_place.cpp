// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/simulation/insertion/tip_place.h"

#include <algorithm>
#include <cassert>

#include "server/simulation/insertion/path_tangents.h"

namespace acus {

namespace {

// A tip this close to the end of its path is there: one at rest must not come and go by rounding.
constexpr double kAtEnd = 1e-6;  // m
// A tip pulled back by more than this (in spacings) from a border does not rest against it any more.
constexpr double kBorderClearance = 0.1;
// Softer than this (in W of the rows) a vertex holds nothing.
constexpr double kSoftest = 1e6;

// Where the base takes the tip is not yet where it goes: a needle bent against a border follows it a long way.
double end_clearance(const InsertionView& at, const Path& path, bool held) {
  if (!held) return kAtEnd;
  return kBorderClearance * path.spacing + (at.needle.tip().position - at.needle.start_tip()).norm();
}

// The last vertex fades in as the cut leaves it behind; a tip pulled back to it is held by it alone.
double last_vertex_softness(const Path& path, int holding, double u) {
  const double tail_spacings = path.tail / path.spacing + static_cast<double>(path.vertices.size()) - holding;
  if (tail_spacings >= 1) return 0;
  const double soft = (1 - tail_spacings) / std::max(tail_spacings, 1 / kSoftest);
  return std::min(kSoftest, u * soft * soft);
}

}  // namespace

void enter(Insertion& insertion, int path, double needle_length) {
  assert(path >= 0 && insertion.path < 0);
  insertion.path = path;
  insertion.phase = Phase::inside;
  insertion.tip = TipMemory{};
  std::fill(insertion.vertices.begin(), insertion.vertices.end(), VertexMemory{.s = needle_length});
  insertion.end_s = needle_length;
  insertion.end_force.setZero();
}

void place_tip(const InsertionView& at, const Path& path, InsertionWork& work) {
  const Insertion& memory = work.next;
  TipPlace& tip = work.located.tip;
  const Vector3 needle_tangent = at.needle.tip().tangent;
  const double length = at.needle.model.length;
  const int count = holding_vertices(path);
  const bool held = memory.held >= 0;
  assert(count > 0 && count <= static_cast<int>(memory.vertices.size()));
  int next = 0;
  while (next < count && memory.vertices[next].s <= length) ++next;
  if (held) next = count;           // what slides on a border is at the end, wherever it came from
  const bool tail = next == count;  // between the last vertex and the end
  const double next_s = tail ? memory.end_s : memory.vertices[next].s;
  tip.in_tail = tail && !path.exited;
  tip.at_end = tip.in_tail && next_s <= length + end_clearance(at, path, held);
  tip.offset = 0;
  tip.cutting = at.cutting_direction();
  double u = 1;  // of the way from the last vertex alongside to the next, or to the end
  if (tip.at_end || next == 0) {
    tip.point = {tip.at_end ? path.end : path.vertices[0], {}, 0};
    tip.softness = 0;
    tip.tangent = tip.at_end ? tip.cutting : needle_tangent;
  } else {
    const double from_s = memory.vertices[next - 1].s;
    if (next_s > from_s) u = std::clamp((length - from_s) / (next_s - from_s), 0.0, 1.0);
    tip.point = {path.vertices[next - 1], tail ? path.end : path.vertices[next], u};
    tip.softness = (1 - u) * (1 - u);
    if (tail) tip.offset = u;
    const Vector3 from = path_tangent(at.tissue, path, next - 1, needle_tangent);
    const Vector3 to = tail ? end_tangent(at.tissue, path, needle_tangent)
                            : path_tangent(at.tissue, path, next, needle_tangent);
    tip.tangent = ((1 - u) * from + u * to).normalized();
  }
  if (!tip.in_tail || work.located.shaft.empty()) return;
  work.located.shaft.back().softness = last_vertex_softness(path, count, u);
}

}  // namespace acus
