// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/tick/insertion/transitions/path_growth.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "server/engine/state/needle/enums.h"
#include "server/engine/tick/insertion/path_direction.h"
#include "server/engine/tick/insertion/tip_laws.h"

namespace acus {

namespace {

// The path's end after a cut. A tip that bears f_c has cut up to its local compliance times f_c behind itself, and the
// end never moves back. The end moves along the cutting direction through the material; the tip's sideways distance
// from it is lateral compliance of the tissue, which moves along. Tissue that the tip comes to has not crept: what is
// ahead of it forgets as it cuts, over the radius on which it loads the tissue.
Vector3 cut_place(const InsertionView& at, const Path& path, const BorderAhead& border, Creep& creep) {
  const Vector3 from = at.tissue.position(path.end), direction = at.cutting_direction();
  const double f_c = at.tissue.interaction(path.end).cutting_force;
  const double ahead = direction.dot(at.needle.tip().position - from);
  if (at.tissue.relaxes() && f_c > 0) {
    const double cut = std::max(0.0, ahead - cut_spring(at, path.end, creep, border).lead(f_c));
    creep.along *= std::exp(-cut / at.tissue.tip_radii(path.end, at.parameters.outer_diameter, f_c).inner);
  }
  const double way = ahead - cut_spring(at, path.end, creep, border).lead(f_c);
  return way > 0 ? Vector3(from + way_through_material(at.tissue, path.end, direction, way)) : from;
}

// The t in [0, 1] at which |a + t b| grows to `distance` (m); |a + b| is at least that.
double way_to_distance(const Vector3& a, const Vector3& b, double distance) {
  const double aa = a.squaredNorm() - distance * distance, ab = a.dot(b), bb = b.squaredNorm();
  if (aa >= 0 || bb == 0) return 0;  // it is already that far, as tissue has stretched since
  return std::min(1.0, (std::sqrt(ab * ab - aa * bb) - ab) / bb);
}

}  // namespace

std::uint32_t grow(const Transition& now, Path& path, int start, int came_from, const BorderAhead& border) {
  const TissueView& tissue = now.at.tissue;
  Insertion& state = now.state;
  const Vector3 to = cut_place(now.at, path, border, state.tip.cut.creep);
  std::uint32_t flags = 0;
  for (int i = 0; i < kMaxCrossings && start >= 0; ++i) {
    const Vector3 from = tissue.position(path.end);
    const Trace trace = trace_segment(tissue.mesh, tissue.x, start, from, to, tissue.regions, came_from);
    flags |= lay_vertices(now, path, start, from, tissue.position(trace.end));
    path.end = trace.end;
    path.exited = trace.left && trace.end.weights.minCoeff() > -1e-6;
    if (trace.next < 0) break;
    const int region = tissue.regions[trace.next];
    if (tissue.border(trace.end, region).holds) {
      if (state.border != region)
        now.report(EventKind::contact, region, std::max(state.tip.contact.along, state.tip.cut.along));
      state.border = region;
      return flags;
    }
    now.report(EventKind::crossing, region, state.tip.cut.along);
    came_from = trace.end.tetrahedron;
    start = trace.next;
  }
  leave_border(now);
  return flags;
}

std::uint32_t slide(const Transition& now, Path& path, const MaterialPoint& end) {
  assert(now.state.border >= 0);
  const TissueView& tissue = now.at.tissue;
  const Surface& border = tissue.borders.surface(now.state.border);
  const auto last = [&](std::size_t k) { return tissue.position(path.vertices[path.vertices.size() - k]); };
  Vector3 from = tissue.position(path.end);
  const Vector3 to = tissue.position(end);
  path.end = end;
  while (path.vertices.size() > 1 && (to - last(1)).dot(last(1) - last(2)) < 0 &&
         tissue.border_face(path.vertices.back())) {
    path.vertices.pop_back();
    from = last(1);
  }
  Vector3 before = last(1);
  while ((to - before).norm() >= path.spacing) {
    if (path.vertices.full()) {
      path.tail = (to - last(1)).norm();
      return kPathFull;
    }
    from += way_to_distance(from - before, to - from, path.spacing) * (to - from);
    before = from;
    const double behind_tip = (to - before).norm();
    now.state.vertices[path.vertices.size()] = VertexState{.s = now.at.needle.model.length - behind_tip};
    path.vertices.push_back(border.material(border.closest(tissue.x, before)));
  }
  path.tail = (to - last(1)).norm();
  return 0;
}

std::uint32_t lay_vertices(const Transition& now, Path& path, int start, const Vector3& from, const Vector3& to) {
  const double cut = (to - from).norm();
  std::uint32_t flags = 0;
  double next = path.spacing - path.tail;  // along the piece
  while (cut > 0 && next <= cut) {
    if (path.vertices.full()) {
      flags |= kPathFull;
      break;
    }
    const Vector3 place = from + next / cut * (to - from);
    const double behind_tip = (now.at.needle.tip().position - place).norm();
    now.state.vertices[path.vertices.size()] = VertexState{.s = now.at.needle.model.length - behind_tip};
    path.vertices.push_back(trace_segment(now.at.tissue.mesh, now.at.tissue.x, start, from, place).end);
    next += path.spacing;
  }
  path.tail = cut - (next - path.spacing);
  return flags;
}

void leave_border(const Transition& now) {
  Insertion& state = now.state;
  if (state.border < 0) return;
  now.report(EventKind::release, state.border, 0);
  state.border = -1;
  // The cut continues with the force along the border.
  if (state.tip.cut.along == 0)
    state.tip.cut.along = std::max(0.0, -state.tip.contact.across.dot(now.at.cutting_direction()));
}

}  // namespace acus
