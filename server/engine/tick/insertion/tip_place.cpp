// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/tick/insertion/tip_place.h"

#include <algorithm>
#include <cassert>

#include "server/engine/tick/insertion/path_tangents.h"

namespace acus {

namespace {

// A tip this close to the end of its path is there: one at rest must not come and go by rounding.
constexpr double kAtEnd = 1e-6;  // m
// A tip pulled back by more than this (in spacings) from a border does not rest against it any more.
constexpr double kBorderClearance = 0.1;
// Cosine of the largest angle to the last stretch of its path at which a tip cuts.
constexpr double kLeastAlongStretch = 0.5;

// Where the base takes the tip is not yet where it goes: a needle bent against a border follows it a long way.
double end_clearance(const InsertionView& at, const Path& path, bool held) {
  if (!held) return kAtEnd;
  return kBorderClearance * path.spacing + (at.needle.tip().position - at.needle.start_tip()).norm();
}

// Whether the tip points along the last stretch of its path, and not across it, as a needle does that has buckled.
bool points_along(const InsertionView& at, const Path& path, const Vector3& cutting) {
  const int last = holding_vertices(path) - 1;
  const Vector3 stretch = at.tissue.position(path.end) - at.tissue.position(path.vertices[last]);
  return cutting.dot(stretch) >= kLeastAlongStretch * stretch.norm();
}

}  // namespace

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
  tip.cutting = at.cutting_direction();
  tip.in_tail = tail && !path.exited;
  const double past_end = tip.cutting.dot(at.needle.tip().position - at.tissue.position(path.end));
  tip.at_end = tip.in_tail && past_end >= -end_clearance(at, path, held) &&
               (held || points_along(at, path, tip.cutting));
  if (tip.at_end || next == 0 || path.air_behind(next - 1)) {
    tip.point = {tip.at_end ? path.end : path.vertices[next], {}, 0};
    tip.tangent = tip.at_end ? tip.cutting : needle_tangent;
    return;
  }
  const double from_s = memory.vertices[next - 1].s;
  const double u = next_s > from_s ? std::clamp((length - from_s) / (next_s - from_s), 0.0, 1.0) : 1;
  tip.point = {path.vertices[next - 1], tail ? path.end : path.vertices[next], u};
  const Vector3 from = path_tangent(at.tissue, path, next - 1, needle_tangent);
  const Vector3 to = tail ? end_tangent(at.tissue, path, needle_tangent)
                          : path_tangent(at.tissue, path, next, needle_tangent);
  tip.tangent = ((1 - u) * from + u * to).normalized();
}

}  // namespace acus
