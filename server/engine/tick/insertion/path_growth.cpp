// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/tick/insertion/path_growth.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "server/engine/state/enums.h"
#include "server/engine/tick/insertion/material_direction.h"
#include "server/engine/tick/insertion/tip_compliance.h"

namespace acus {

namespace {

// Up to where a tip has cut that bears f_c: behind it by what gives way there, but never back. The end goes along the
// cutting direction through the material: what the tip stands beside it is give of the tissue, which goes along.
Vector3 cut_place(const InsertionView& at, const Path& path, double ahead) {
  const Vector3 from = at.tissue.position(path.end), direction = at.cutting_direction();
  const double give = cutting_compliance(at, path, ahead) * at.tissue.interaction(path.end).cutting_force;
  const double way = direction.dot(at.needle.tip().position - from) - give;
  return way > 0 ? Vector3(from + way_through_material(at.tissue, path.end, direction, way)) : from;
}

// The t in [0, 1] at which |a + t b| grows to `distance` (m); |a + b| is at least that.
double way_to_distance(const Vector3& a, const Vector3& b, double distance) {
  const double aa = a.squaredNorm() - distance * distance, ab = a.dot(b), bb = b.squaredNorm();
  if (aa >= 0 || bb == 0) return 0;  // it is already that far, as tissue has stretched since
  return std::min(1.0, (std::sqrt(ab * ab - aa * bb) - ab) / bb);
}

}  // namespace

std::uint32_t grow(const Transition& now, Path& path, int start, int came_from, double ahead) {
  const TissueView& tissue = now.at.tissue;
  Insertion& memory = now.memory;
  const Vector3 to = cut_place(now.at, path, ahead);
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
      if (memory.held != region) now.report(EventKind::contact, region, memory.tip.contact);
      memory.held = region;
      return flags;
    }
    now.report(EventKind::crossing, region, memory.tip.cutting);
    came_from = trace.end.tetrahedron;
    start = trace.next;
  }
  leave_border(now);
  return flags;
}

std::uint32_t slide(const Transition& now, Path& path, const MaterialPoint& end) {
  assert(now.memory.held >= 0);
  const TissueView& tissue = now.at.tissue;
  const Surface& border = tissue.borders.surface(now.memory.held);
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
    now.memory.vertices[path.vertices.size()] = VertexMemory{.s = now.at.needle.model.length - behind_tip};
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
    now.memory.vertices[path.vertices.size()] = VertexMemory{.s = now.at.needle.model.length - behind_tip};
    path.vertices.push_back(trace_segment(now.at.tissue.mesh, now.at.tissue.x, start, from, place).end);
    next += path.spacing;
  }
  path.tail = cut - (next - path.spacing);
  return flags;
}

void leave_border(const Transition& now) {
  Insertion& memory = now.memory;
  if (memory.held < 0) return;
  now.report(EventKind::release, memory.held, 0);
  memory.held = -1;
  // The cut goes on with the force that it had along the border.
  if (memory.tip.cutting == 0)
    memory.tip.cutting = std::max(0.0, -memory.tip.lateral.dot(now.at.cutting_direction()));
}

}  // namespace acus
