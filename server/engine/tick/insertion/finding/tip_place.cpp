// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/tick/insertion/finding/tip_place.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "server/engine/tick/insertion/finding/obstacle.h"
#include "server/engine/tick/insertion/path_direction.h"

namespace acus {

namespace {

// Distance from the end of the path within which a tip counts as at the end, so that rounding cannot move it in and
// out.
constexpr double kAtEnd = 1e-6;  // m
// A tip pulled back by more than this (in spacings) from a border has left it.
constexpr double kBorderClearance = 0.1;
// Cosine of the largest angle to the last stretch of its path at which a tip cuts.
constexpr double kLeastAlongStretch = 0.5;

// On a border the tip's free motion counts too: a needle bent against a border springs far in free motion, and stays.
double end_clearance(const InsertionView& at, const Path& path, bool held) {
  if (!held) return kAtEnd;
  return kBorderClearance * path.spacing + (at.needle.tip().position - at.needle.start_tip()).norm();
}

// Whether the tip points along the last stretch of its path. A buckled needle points across it.
bool points_along(const InsertionView& at, const Path& path, const Vector3& cutting) {
  const int last = holding_vertices(path) - 1;
  const Vector3 stretch = at.tissue.position(path.end) - at.tissue.position(path.vertices[last]);
  return cutting.dot(stretch) >= kLeastAlongStretch * stretch.norm();
}

}  // namespace

void place_tip(const InsertionView& at, const Path& path, InsertionScratch& scratch) {
  const Insertion& state = scratch.next;
  TipPlace& tip = scratch.located.tip;
  const Vector3 needle_tangent = at.needle.tip().tangent;
  const double length = at.needle.model.length;
  const int count = holding_vertices(path);
  const bool held = state.border >= 0;
  assert(count > 0 && count <= static_cast<int>(state.vertices.size()));
  int next = 0;
  while (next < count && state.vertices[next].s <= length) ++next;
  if (held) next = count;           // a tip on a border is at the end
  const bool tail = next == count;  // between the last vertex and the end
  const double next_s = tail ? state.end_s : state.vertices[next].s;
  tip.cutting = at.cutting_direction();
  tip.in_tail = tail && !path.exited;
  const double past_end = tip.cutting.dot(at.needle.tip().position - at.tissue.position(path.end));
  // A loaded border moves along with a tip that is drawn back.
  const bool near_end = (held && state.tip.contact.along > 0) || past_end >= -end_clearance(at, path, held);
  tip.at_end = tip.in_tail && near_end && (held || points_along(at, path, tip.cutting));
  tip.next = tip.at_end || tail ? -1 : next;
  if (tip.at_end || next == 0 || path.air_behind(next - 1)) {
    tip.point = {tip.at_end ? path.end : path.vertices[next], {}, 0};
    tip.tangent = tip.at_end ? tip.cutting : needle_tangent;
    return;
  }
  const double from_s = state.vertices[next - 1].s;
  const double u = next_s > from_s ? std::clamp((length - from_s) / (next_s - from_s), 0.0, 1.0) : 1;
  tip.behind = next - 1;
  tip.point = {path.vertices[next - 1], tail ? path.end : path.vertices[next], u};
  const Vector3 from = path_tangent(at.tissue, path, next - 1, needle_tangent);
  const Vector3 to = tail ? end_tangent(at.tissue, path, needle_tangent)
                          : path_tangent(at.tissue, path, next, needle_tangent);
  tip.tangent = ((1 - u) * from + u * to).normalized();
}

Reached reach_to(const TissueView& tissue, const MaterialPoint& from, const Vector3& to, bool torn) {
  MaterialPoint end = from;
  int start = from.tetrahedron, came_from = -1;
  for (int i = 0; i < kMaxCrossings; ++i) {
    const Trace trace =
        trace_segment(tissue.mesh, tissue.x, start, tissue.position(end), to, tissue.regions, came_from);
    end = trace.end;
    if (trace.next < 0) return {end, -1, trace.left};
    const int region = tissue.regions[trace.next];
    const Border& border = tissue.border(end, region);
    if (torn ? std::isinf(border.puncture_force) : border.holds) return {end, region, false};
    came_from = end.tetrahedron;
    start = trace.next;
  }
  return {end, -1, false};
}

std::optional<BorderPlace> first_border(const TissueView& tissue, const Path& path, const Vector3& to) {
  const Reached reached = reach_to(tissue, path.end, to);
  if (reached.border < 0) return std::nullopt;
  return BorderPlace{reached.border, tissue.position(reached.end)};
}

void find_border(const InsertionView& at, const Path& path, InsertionScratch& scratch) {
  assert(!path.empty());
  const TissueView& tissue = at.tissue;
  TipPlace& tip = scratch.located.tip;
  if (!tip.in_tail || !tissue.borders.any()) return;
  Insertion& state = scratch.next;
  std::optional<Obstacle>& obstacle = scratch.located.obstacle;
  if (state.border >= 0 && tip.at_end) {
    obstacle = border_ahead(at, state.border, tissue.position(path.end), state);
    press_on_border(at, *obstacle, state.tip);
    return;
  }
  const Vector3 position = at.needle.tip().position, direction = at.cutting_direction();
  const Vector3 end = tissue.position(path.end);
  const double lead = std::max(0.0, direction.dot(position - end));
  const double reach = kContactMargin + 2 * (position - at.needle.start_tip()).norm() + lead;
  const auto border = first_border(tissue, path, end + reach * direction);
  if (!border) return;
  if (border->region != state.border) state.tip.contact.along = 0;
  obstacle = border_ahead(at, border->region, border->place, state);
  obstacle->under = tip.at_end && height(tissue, *obstacle, tip_of(at)) + obstacle->dimple_before < 0;
  tip.ahead = border_on_the_way(at, path, *obstacle, height_before(*obstacle, tip_of(at)));
  if (obstacle->under) press_on_border(at, *obstacle, state.tip);
}

}  // namespace acus
