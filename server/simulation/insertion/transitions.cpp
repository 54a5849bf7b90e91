// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/simulation/insertion/transitions.h"

#include <algorithm>

#include "server/simulation/enums.h"
#include "server/simulation/insertion/path_growth.h"
#include "server/simulation/insertion/path_tangents.h"
#include "server/simulation/insertion/tip_give.h"
#include "server/simulation/insertion/tip_place.h"

namespace acus {

namespace {

// A path that has grown by less was stopped where it began.
constexpr double kBlocked = 1e-6;  // m
// A tip that sticks to a surface slides by rounding.
constexpr double kLeastSlip = 1e-9;  // m

// Which of two paths a new one may take the place of: empty ones first, then the one left longest ago.
bool forgotten_before(const Path& a, const Path& b) {
  const auto rank = [](const Path& p) { return p.empty() ? 0 : p.needle < 0 ? 1 : 2; };
  return rank(a) != rank(b) ? rank(a) < rank(b) : a.left < b.left;
}

// The path that a new one may take the place of, or nullptr where a needle is in every one.
Path* find_vacant(std::vector<Path>& paths) {
  const auto vacant = std::min_element(paths.begin(), paths.end(), forgotten_before);
  return vacant->needle >= 0 ? nullptr : &*vacant;
}

void open_path(const Transition& now, Path& path, const MaterialPoint& mouth) {
  path.begin(mouth, now.at.parameters.constraint_spacing);
  enter(now.memory, static_cast<int>(&path - now.paths.data()), now.at.parameters.length);
  path.needle = now.at.needle_index;
}

// Where the needle crosses the surface, not further behind the tip than the surface can be; the point of contact is where
// the tip was a tick ago.
MaterialPoint new_mouth(const Transition& now, const Obstacle& obstacle, double contact) {
  const TissueView& tissue = now.at.tissue;
  const CurvePoint tip = now.at.needle.tip();
  const double depth = kContactMargin + obstacle.compliance * contact;
  const auto crossing = tissue.surface.entry(tissue.x, tip.position - depth * tip.tangent, tip.position);
  return crossing ? tissue.surface.material(*crossing) : obstacle.material;
}

// The point of the surface under a tip that slid in the tick.
MaterialPoint slid_point(const Transition& now, const Obstacle& obstacle) {
  const TissueView& tissue = now.at.tissue;
  const NeedleView& needle = now.at.needle;
  const Vector3 moved = needle.tip().position - needle.start_tip() -
                        mean_position(tissue.mesh, tissue.x, *obstacle.patch) + obstacle.patch->middle;
  const Vector3& n = obstacle.at.normal;
  const Vector3 slid = moved - n.dot(moved) * n;
  if (slid.norm() < kLeastSlip) return obstacle.material;
  return tissue.surface.material(tissue.surface.closest(tissue.x, tissue.position(obstacle.material) + slid));
}

// Whether the tip has pressed an element under it flat. The tissue bears no more than that, whatever f_p is.
bool has_crushed(const TissueView& tissue, const ContactPatch& patch) {
  return std::ranges::any_of(patch.points, [&](const MaterialPoint& point) {
    return signed_volume(tissue.x, tissue.mesh.tetrahedra[static_cast<std::size_t>(point.tetrahedron)]) <= 0;
  });
}

void leave_contact_or_puncture(const Transition& now) {
  Insertion& memory = now.memory;
  const auto& obstacle = now.work.located.obstacle;
  const double contact = memory.tip.contact;
  const bool pressed = obstacle && contact > 0;
  const int region = obstacle ? obstacle->region : 0;
  if (pressed && memory.phase == Phase::free) now.report(EventKind::contact, region, contact);
  if (!pressed && memory.phase == Phase::contact) now.report(EventKind::release, region, 0);
  memory.phase = pressed ? Phase::contact : Phase::free;
  memory.touched = pressed ? slid_point(now, *obstacle) : MaterialPoint{};
  const bool punctured = obstacle && (now.work.puncturing || (pressed && has_crushed(now.at.tissue, *obstacle->patch)));
  if (!punctured) return;

  Path* const path = find_vacant(now.paths);
  if (!path) return;  // the surface keeps its cap
  now.report(EventKind::puncture, region, contact);
  const MaterialPoint mouth = new_mouth(now, *obstacle, contact);
  open_path(now, *path, mouth);
  grow(now, *path, mouth.tetrahedron, -1);
  if (path->exited) path->begin(mouth, now.at.parameters.constraint_spacing);  // grazing an edge: back to its mouth
  // The cut goes on from what the surface bore.
  memory.tip.cutting = std::min(contact, now.at.tissue.interaction(path->end).cutting_force);
}

// A tip that lost its contact, as elements turned inside out under it, or was torn or thrown into the tissue stands there
// without a path: one is opened from where the needle crosses the surface straight to the tip.
std::uint32_t open_where_found(const Transition& now) {
  const TissueView& tissue = now.at.tissue;
  if (now.memory.path >= 0 || now.memory.phase != Phase::free) return 0;
  const CurvePoint tip = now.at.needle.tip();
  if (!tissue.surface.near(tissue.x, tip.position, 0)) return 0;
  const int inside = find_tetrahedron(tissue.mesh, tissue.x, tip.position);
  if (inside < 0) return 0;
  const SurfacePoint closest = tissue.surface.closest(tissue.x, tip.position);
  if ((tip.position - closest.position).norm() < kUnnoticed) return 0;
  Path* const path = find_vacant(now.paths);
  if (!path) return kTipFoundInside;

  const MaterialPoint end{inside, barycentric(tissue.mesh, tissue.x, inside, tip.position)};
  now.report(EventKind::intrusion, tissue.region(end), 0);
  const Vector3 behind = tip.position - now.at.needle.model.length * tip.tangent;
  const auto crossing = tissue.surface.entry(tissue.x, behind, tip.position);
  const MaterialPoint mouth = tissue.surface.material(crossing ? *crossing : closest);
  open_path(now, *path, mouth);
  const std::uint32_t flags =
      lay_vertices(now, *path, mouth.tetrahedron, tissue.position(mouth), tip.position);
  path->end = end;
  return flags | kTipFoundInside;
}

// Whether the tip is before the mouth of its path. One that has just made the mouth may stand before it, until the
// surface that it had pressed in comes back; it is withdrawn if it goes back itself.
bool is_withdrawn(const InsertionView& at, const Path& path, const Insertion& memory) {
  const CurvePoint tip = at.needle.tip();
  if (memory.depth == 0 && tip.tangent.dot(tip.position - at.needle.start_tip()) >= 0) return false;
  const Vector3 mouth_tangent = path_tangent(at.tissue, path, 0, tip.tangent);
  const Vector3 past = tip.position - at.tissue.position(path.vertices[0]);
  return mouth_tangent.dot(past) < 0 && tip.tangent.dot(past) < 0;
}

// From the tip to the border that it has found ahead (m).
double ahead_of(const Transition& now) {
  const auto& border = now.work.located.obstacle;
  if (!border) return kInfinity;
  return distance_ahead(now.at, *border, now.at.needle.tip().position, now.at.tissue.position(border->material));
}

// The tip presses on a border, or has slid along it.
std::uint32_t meet_border(const Transition& now, Path& path, const Obstacle& obstacle) {
  const TissueView& tissue = now.at.tissue;
  Insertion& memory = now.memory;
  const Surface& surface = tissue.borders.surface(obstacle.region);
  const int start = path.end.tetrahedron;
  const Vector3 from = tissue.position(path.end);
  if (now.work.puncturing) {
    if (memory.held < 0) now.report(EventKind::contact, obstacle.region, memory.tip.contact);
    now.report(EventKind::crossing, obstacle.region, memory.tip.contact);
    memory.held = -1;
    const std::uint32_t flags = lay_vertices(now, path, start, from, tissue.position(obstacle.material));
    path.end = obstacle.material;
    return flags | grow(now, path, surface.beyond(obstacle.at), path.end.tetrahedron);
  }
  // Along the plane of contact: a tip behind a thin layer is nearer to the layer's other side.
  const Vector3& n = obstacle.at.normal;
  const Vector3 tip = now.at.needle.tip().position;
  const Vector3 on_plane = tip - n.dot(tip - tissue.position(obstacle.material)) * n;
  const SurfacePoint under = surface.closest(tissue.x, on_plane);
  const Vector3 off_rim = on_plane - under.position - under.distance * under.normal;
  const bool beside = off_rim.norm() > kContactMargin;
  if (memory.tip.contact > 0 && !beside) {
    if (memory.held < 0) now.report(EventKind::contact, obstacle.region, memory.tip.contact);
    memory.held = obstacle.region;
    return slide(now, path, surface.material(under));
  }
  if (!beside && now.at.cutting_direction().dot(tip - from) <= 0) {
    leave_border(now);
    return 0;
  }
  const std::uint32_t flags = grow(now, path, start, -1, ahead_of(now));
  if (memory.held != obstacle.region || (tissue.position(path.end) - from).norm() > kBlocked) return flags;
  // The straight way cuts a corner of the region that bears nothing: the end follows the tip along the surface.
  const SurfacePoint foot = surface.closest(tissue.x, tip);
  const std::uint32_t slid = slide(now, path, surface.material(foot));
  if (foot.distance <= kContactMargin) return flags | slid;
  return flags | slid | grow(now, path, path.end.tetrahedron, -1, ahead_of(now));
}

// The path's end after a tick inside: the border that holds it, growth, exit.
std::uint32_t advance_end(const Transition& now, Path& path) {
  Insertion& memory = now.memory;
  const auto& obstacle = now.work.located.obstacle;
  if (obstacle && (obstacle->under || memory.tip.contact > 0)) return meet_border(now, path, *obstacle);
  leave_border(now);

  const CurvePoint tip = now.at.needle.tip();
  const bool beyond = tip.tangent.dot(tip.position - now.at.tissue.position(path.end)) > 0;
  const bool gives_way = now.work.cutting || now.at.tissue.interaction(path.end).cutting_force == 0;
  std::uint32_t flags = 0;
  if (!path.exited && beyond && gives_way) {
    const int region = now.at.tissue.region(path.end);
    flags = grow(now, path, path.end.tetrahedron, -1, ahead_of(now));
    if (path.exited) now.report(EventKind::exit, region, memory.tip.cutting);
  } else if (path.exited && beyond != (memory.phase == Phase::through)) {
    now.report(beyond ? EventKind::exit : EventKind::reentry, now.at.tissue.region(path.end), 0);
  }
  if (path.exited) memory.phase = beyond ? Phase::through : Phase::inside;
  return flags;
}

// Of the needle where the tick has left it, not where the base would have taken it.
void measure_depth(const Transition& now) {
  Insertion& memory = now.memory;
  memory.depth = 0;
  if (memory.path < 0) return;
  const Path& path = now.paths[memory.path];
  const NeedleView& needle = now.at.needle;
  const Vector3 tip_tangent = needle.tip().tangent;
  const auto place = [&](const MaterialPoint& point, const Vector3& tangent, double guess) {
    return project_on_curve(needle, now.at.tissue.position(point), tangent, guess);
  };
  const double mouth = place(path.vertices[0], path_tangent(now.at.tissue, path, 0, tip_tangent),
                             memory.vertices[0].s);
  double end = needle.model.length;
  if (memory.phase == Phase::through)
    end = std::min(end, place(path.end, end_tangent(now.at.tissue, path, tip_tangent), memory.end_s));
  memory.depth = std::max(0.0, end - std::max(0.0, mouth));
}

std::uint32_t go_on(const Transition& now) {
  if (now.memory.path < 0) {
    leave_contact_or_puncture(now);
    return open_where_found(now);
  }
  Path& path = now.paths[now.memory.path];
  if (now.work.located.reentered) {
    if (now.work.located.far_end) path.turn_round();
    path.needle = now.at.needle_index;
    now.report(EventKind::reentry, now.at.tissue.region(path.vertices[0]), 0);
  }
  if (!is_withdrawn(now.at, path, now.memory)) return advance_end(now, path);
  now.report(EventKind::withdrawal, now.at.tissue.region(path.vertices[0]), 0);
  path.needle = -1;
  path.left = now.tick;
  forget(now.memory);
  return 0;
}

}  // namespace

void Transition::report(EventKind kind, int region, double force) const {
  if (events.size() == events.capacity()) return;
  events.push_back({tick, at.needle_index, kind, region, at.needle.tip().position, force});
}

std::uint32_t insertion_transitions(const Transition& now) {
  const std::uint32_t flags = go_on(now);
  measure_depth(now);
  return flags;
}

std::optional<ContactPatch> patch_ahead(const InsertionView& at, const Insertion& memory, double distance) {
  if (memory.phase != Phase::free) return std::nullopt;
  const TissueView& tissue = at.tissue;
  const CurvePoint tip = at.needle.tip();
  if (!tissue.surface.near(tissue.x, tip.position, distance)) return std::nullopt;
  const auto entry = tissue.surface.entry(tissue.x, tip.position, tip.position + distance * tip.tangent);
  if (!entry) return std::nullopt;
  const MaterialPoint centre = tissue.surface.material(*entry);
  return make_contact_patch(tissue, centre, tissue.contact_radius(centre, at.parameters.outer_diameter));
}

int tetrahedron_ahead(const InsertionView& at, const InsertionWork& work, const Insertion& memory,
                      std::span<const Path> paths, double distance) {
  const bool cuts = memory.phase == Phase::inside && work.located.tip.in_tail;
  if (!cuts && !(memory.phase == Phase::contact && work.located.obstacle)) return -1;
  const MaterialPoint& start = cuts ? paths[memory.path].end : work.located.obstacle->material;
  const Vector3 from = at.tissue.position(start), to = from + distance * at.cutting_direction();
  return trace_segment(at.tissue.mesh, at.tissue.x, start.tetrahedron, from, to).end.tetrahedron;
}

}  // namespace acus
