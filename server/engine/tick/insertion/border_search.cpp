// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/tick/insertion/border_search.h"

#include <algorithm>
#include <cassert>

#include "server/engine/tick/insertion/tip_compliance.h"

namespace acus {

namespace {

Obstacle closest_on(const TissueView& tissue, int region, const Vector3& p) {
  const Surface& surface = tissue.borders.surface(region);
  const SurfacePoint at = surface.closest(tissue.x, p);
  return {.region = region, .at = at, .material = surface.material(at), .patch = {}};
}

}  // namespace

void find_border(const InsertionView& at, const Path& path, InsertionWork& work) {
  assert(!path.empty());
  const TissueView& tissue = at.tissue;
  TipPlace& tip = work.located.tip;
  if (!tip.in_tail || !tissue.borders.any()) return;
  if (work.next.held >= 0 && tip.at_end) {
    work.located.obstacle = closest_on(tissue, work.next.held, tissue.position(path.end));
    return;
  }
  const Vector3 position = at.needle.tip().position, direction = at.cutting_direction();
  Vector3 from = tissue.position(path.end);
  const double lead = std::max(0.0, direction.dot(position - from));
  const double reach = kContactMargin + 2 * (position - at.needle.start_tip()).norm() + lead;
  const Vector3 to = from + reach * direction;
  int start = path.end.tetrahedron, came_from = -1;
  for (int i = 0; i < kMaxCrossings; ++i) {
    const Trace trace = trace_segment(tissue.mesh, tissue.x, start, from, to, tissue.regions, came_from);
    if (trace.next < 0) return;
    from = tissue.position(trace.end);
    const int region = tissue.regions[trace.next];
    if (tissue.border(trace.end, region).holds) {
      Obstacle& obstacle = work.located.obstacle.emplace(closest_on(tissue, region, from));
      obstacle.under = tip.at_end && obstacle.at.normal.dot(position - obstacle.at.position) < 0;
      tip.ahead = distance_ahead(at, obstacle, at.needle.start_tip(), tissue.start_position(obstacle.material));
      return;
    }
    came_from = trace.end.tetrahedron;
    start = trace.next;
  }
}

}  // namespace acus
