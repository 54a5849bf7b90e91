// SPDX-License-Identifier: GPL-3.0-or-later
// An insertion's memory, and its stage 9: what a tick has changed. Stages 4 and 5 are in insertion_locate.cpp and
// insertion_rows.cpp.
#include "server/simulation/insertion.h"

#include <algorithm>
#include <cmath>

namespace acus {

namespace {

// Which of two paths a new one may take the place of: empty ones first, then the one left longest ago.
bool forgotten_before(const Path& a, const Path& b) {
  const auto rank = [](const Path& p) { return p.empty() ? 0 : p.needle < 0 ? 1 : 2; };
  return rank(a) != rank(b) ? rank(a) < rank(b) : a.left < b.left;
}

}  // namespace

int Insertion::max_points(const Needle& p) {
  return 2 * static_cast<int>(std::ceil(p.length / p.constraint_spacing)) + 4;
}

Insertion::Insertion(int needle, const Needle& parameters, int path_capacity)
    : needle_(needle), parameters_(parameters), cutting_direction_(parameters.cutting_direction.normalized()) {
  memory_.resize(static_cast<std::size_t>(path_capacity));
  shaft_.reserve(static_cast<std::size_t>(max_points(parameters)));
}

void Insertion::reset() {
  phase_ = Phase::free;
  path_ = -1;
  depth_ = 0;
  reentered_ = puncturing_ = cutting_ = in_tail_ = at_end_ = false;
  held_ = -1;
  obstacle_.reset();
  std::fill(memory_.begin(), memory_.end(), Memory{});
  shaft_.clear();
  tip_ = TipMemory{};
}

std::uint32_t Insertion::transitions(const NeedleView& needle, const TissueView& tissue, std::uint64_t tick,
                                     std::vector<Path>& paths, std::vector<Event>& events) {
  const Transition now{needle, tissue, tick, events};
  if (path_ < 0) {
    leave_contact_or_puncture(now, paths);
    return open_where_found(now, paths);
  }
  Path& path = paths[path_];
  const int mouth_region = tissue.region(path.vertices[0]);
  if (reentered_) report(now, EventKind::reentry, mouth_region, 0);
  reentered_ = false;

  const CurvePoint tip = needle.tip();
  const Vector3 mouth_tangent = path_tangent(tissue, path, 0, tip.tangent);
  if (mouth_tangent.dot(tip.position - tissue.position(path.vertices[0])) < 0 &&
      tip.tangent.dot(tip.position - tissue.position(path.vertices[0])) < 0) {
    report(now, EventKind::withdrawal, mouth_region, 0);
    path.needle = -1;
    path.left = tick;
    reset();
    return 0;
  }
  return advance_end(now, path);
}

void Insertion::report(const Transition& now, EventKind kind, int region, double force) const {
  if (now.events.size() == now.events.capacity()) return;
  now.events.push_back({now.tick, needle_, kind, region, now.needle.tip().position, force});
}

void Insertion::leave_contact_or_puncture(const Transition& now, std::vector<Path>& paths) {
  depth_ = 0;
  const bool pressed = obstacle_ && tip_.contact > 0;
  const int region = obstacle_ ? obstacle_->region : 0;
  if (pressed && phase_ == Phase::free) report(now, EventKind::contact, region, tip_.contact);
  if (!pressed && phase_ == Phase::contact) report(now, EventKind::release, region, 0);
  phase_ = pressed ? Phase::contact : Phase::free;
  if (!obstacle_ || !puncturing_) return;

  const auto vacant = std::min_element(paths.begin(), paths.end(), forgotten_before);
  if (vacant->needle >= 0) return;  // a needle in every path: the surface keeps its cap
  report(now, EventKind::puncture, region, tip_.contact);
  place_mouth(now.needle.tip(), now.tissue, kContactMargin + surface_compliance(now.tissue) * tip_.contact);
  const MaterialPoint mouth = obstacle_->material;
  vacant->begin(mouth, parameters_.constraint_spacing);
  enter(static_cast<int>(vacant - paths.begin()), paths);
  grow(now, *vacant, mouth.tetrahedron, -1);
  if (vacant->exited) vacant->begin(mouth, parameters_.constraint_spacing);  // grazing an edge: not inside yet
}

// A tip that lost its contact, as elements turned inside out under it, or was torn or thrown into the tissue stands there
// without a path: one is opened from where the needle crosses the surface straight to the tip.
std::uint32_t Insertion::open_where_found(const Transition& now, std::vector<Path>& paths) {
  if (path_ >= 0 || phase_ != Phase::free) return 0;
  const TissueView& tissue = now.tissue;
  const CurvePoint tip = now.needle.tip();
  if (!tissue.surface.near(tissue.x, tip.position, 0)) return 0;
  const int inside = find_tetrahedron(tissue.mesh, tissue.x, tip.position);
  if (inside < 0) return 0;
  const SurfacePoint closest = tissue.surface.closest(tissue.x, tip.position);
  if ((tip.position - closest.position).norm() < kUnnoticed) return 0;
  const auto vacant = std::min_element(paths.begin(), paths.end(), forgotten_before);
  if (vacant->needle >= 0) return kTipFoundInside;

  const MaterialPoint end{inside, barycentric(tissue.mesh, tissue.x, inside, tip.position)};
  report(now, EventKind::intrusion, tissue.region(end), 0);
  const Vector3 behind = tip.position - now.needle.model.length * tip.tangent;
  const auto crossing = tissue.surface.entry(tissue.x, behind, tip.position);
  const MaterialPoint mouth = tissue.surface.material(crossing ? *crossing : closest);
  vacant->begin(mouth, parameters_.constraint_spacing);
  enter(static_cast<int>(vacant - paths.begin()), paths);
  const std::uint32_t flags = lay_vertices(now, *vacant, mouth.tetrahedron, tissue.position(mouth), tip.position);
  vacant->end = end;
  return flags | kTipFoundInside;
}

// The mouth is where the needle crosses the surface, `depth` (m) before the tip at most; the point of contact is where
// the tip was a tick ago.
void Insertion::place_mouth(const CurvePoint& tip, const TissueView& tissue, double depth) {
  const auto crossing = tissue.surface.entry(tissue.x, tip.position - depth * tip.tangent, tip.position);
  if (crossing) obstacle_->material = tissue.surface.material(*crossing);
}

// The path's end after a tick inside: the border that holds it, growth, exit.
std::uint32_t Insertion::advance_end(const Transition& now, Path& path) {
  if (obstacle_ && (obstacle_->under || tip_.contact > 0)) return meet_border(now, path);
  leave_border(now);

  const CurvePoint tip = now.needle.tip();
  const bool beyond = tip.tangent.dot(tip.position - now.tissue.position(path.end)) > 0;
  const bool gives_way = cutting_ || now.tissue.interaction(path.end).cutting_force == 0;
  std::uint32_t flags = 0;
  if (!path.exited && beyond && gives_way) {
    const int region = now.tissue.region(path.end);
    flags = grow(now, path, path.end.tetrahedron, -1);
    if (path.exited) report(now, EventKind::exit, region, tip_.cutting);
  } else if (path.exited && beyond != (phase_ == Phase::through)) {
    report(now, beyond ? EventKind::exit : EventKind::reentry, now.tissue.region(path.end), 0);
  }
  if (path.exited) phase_ = beyond ? Phase::through : Phase::inside;
  return flags;
}

// The tip presses on a border, or has slid along it.
std::uint32_t Insertion::meet_border(const Transition& now, Path& path) {
  const TissueView& tissue = now.tissue;
  const Surface& surface = tissue.borders.surface(obstacle_->region);
  const int start = path.end.tetrahedron;
  const Vector3 from = tissue.position(path.end);
  if (puncturing_) {
    if (held_ < 0) report(now, EventKind::contact, obstacle_->region, tip_.contact);
    report(now, EventKind::crossing, obstacle_->region, tip_.contact);
    held_ = -1;
    const std::uint32_t flags = lay_vertices(now, path, start, from, tissue.position(obstacle_->material));
    path.end = obstacle_->material;
    return flags | grow(now, path, surface.beyond(obstacle_->at), path.end.tetrahedron);
  }
  // Along the plane of contact: a tip behind a thin layer is nearer to the layer's other side.
  const Vector3& n = obstacle_->at.normal;
  const Vector3 tip = now.needle.tip().position;
  const Vector3 on_plane = tip - n.dot(tip - tissue.position(obstacle_->material)) * n;
  const SurfacePoint under = surface.closest(tissue.x, on_plane);
  const Vector3 off_rim = on_plane - under.position - under.distance * under.normal;
  const bool beside = off_rim.norm() > kContactMargin;
  if (tip_.contact > 0 && !beside) {
    if (held_ < 0) report(now, EventKind::contact, obstacle_->region, tip_.contact);
    held_ = obstacle_->region;
    return slide(now, path, surface.material(under));
  }
  if (beside || cutting_direction(now.needle).dot(tip - from) > 0) return grow(now, path, start, -1);
  leave_border(now);
  return 0;
}

void Insertion::leave_border(const Transition& now) {
  if (held_ >= 0) report(now, EventKind::release, held_, 0);
  held_ = -1;
}

// Moves the path's end along the border that holds it. Vertices that it comes back over are dropped: a tip that is
// dragged to and fro leaves one path, not one for every way.
std::uint32_t Insertion::slide(const Transition& now, Path& path, const MaterialPoint& end) {
  const auto last = [&](std::size_t k) { return now.tissue.position(path.vertices[path.vertices.size() - k]); };
  const Vector3 place = now.tissue.position(end);
  path.end = end;
  while (path.vertices.size() > 1 && (place - last(1)).dot(last(1) - last(2)) < 0 &&
         now.tissue.border_normal(path.vertices.back()))
    path.vertices.pop_back();
  path.tail = (place - last(1)).norm();
  if (path.tail < path.spacing) return 0;
  if (path.vertices.size() == memory_.size()) return kPathFull;
  memory_[path.vertices.size()] = Memory{.s = now.needle.model.length};
  path.vertices.push_back(end);
  path.tail = 0;
  return 0;
}

// Up to where a tip has cut that bears f_c: behind it by what gives way there, but never back.
Vector3 Insertion::cut_place(const Transition& now, const Path& path) const {
  const TissueView& tissue = now.tissue;
  const Vector3 from = tissue.position(path.end), tip = now.needle.tip().position;
  const double give = cutting_compliance(tissue, path) * tissue.interaction(path.end).cutting_force;
  if (give == 0) return tip;
  const Vector3 direction = cutting_direction(now.needle);
  return direction.dot(tip - from) > give ? Vector3(tip - give * direction) : from;
}

// Moves the path's end to where the tip has cut, through every border that does not hold it, to the first one that does. The end lies
// in tetrahedron `start`, or on its face towards `came_from`.
std::uint32_t Insertion::grow(const Transition& now, Path& path, int start, int came_from) {
  const TissueView& tissue = now.tissue;
  const Vector3 to = cut_place(now, path);
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
      if (held_ != region) report(now, EventKind::contact, region, tip_.contact);
      held_ = region;
      return flags;
    }
    report(now, EventKind::crossing, region, tip_.cutting);
    came_from = trace.end.tetrahedron;
    start = trace.next;
  }
  leave_border(now);
  return flags;
}

// Sets the vertices that a straight piece of cut has passed, each at its exact distance.
std::uint32_t Insertion::lay_vertices(const Transition& now, Path& path, int start, const Vector3& from,
                                      const Vector3& to) {
  const double cut = (to - from).norm();
  std::uint32_t flags = 0;
  double next = path.spacing - path.tail;  // along the piece
  while (cut > 0 && next <= cut) {
    if (path.vertices.size() == memory_.size()) {
      flags |= kPathFull;
      break;
    }
    const Vector3 place = from + next / cut * (to - from);
    const double behind_tip = (now.needle.tip().position - place).norm();
    memory_[path.vertices.size()] = Memory{.s = now.needle.model.length - behind_tip};
    path.vertices.push_back(trace_segment(now.tissue.mesh, now.tissue.x, start, from, place).end);
    next += path.spacing;
  }
  path.tail = cut - (next - path.spacing);
  return flags;
}

}  // namespace acus
