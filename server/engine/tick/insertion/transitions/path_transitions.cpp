// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/tick/insertion/transitions/path_transitions.h"

#include <algorithm>

#include "server/engine/state/needle/phase.h"
#include "server/engine/tick/insertion/finding/obstacle.h"
#include "server/engine/tick/insertion/finding/tip_place.h"
#include "server/engine/tick/insertion/path_direction.h"
#include "server/engine/tick/insertion/path_wall.h"
#include "server/engine/tick/insertion/tip_laws.h"
#include "server/engine/tick/insertion/transitions/path_growth.h"
#include "server/engine/tick/insertion/transitions/surface_transitions.h"
#include "server/engine/tick/insertion/transitions/tearing.h"

namespace acus {

namespace {

// Growth of a path below which the cut was stopped where it began.
constexpr double kBlocked = 1e-6;  // m

// Whether the tip is outside the mouth of its path, or of the path's last part, and moves back. After a puncture the
// tip may be outside the new mouth until the surface comes back, without being withdrawn. A tip inside the tissue that
// the mouth was dragged past stays in its path.
bool is_withdrawn(const InsertionView& at, const Path& path, const Insertion& state) {
  const CurvePoint tip = at.needle.tip();
  const int mouth = path.last_mouth();
  const double inside = mouth == 0 ? state.depth : at.needle.model.length - state.vertices[mouth].s;
  if (inside <= 0 && tip.tangent.dot(tip.position - at.needle.start_tip()) >= 0) return false;
  const Vector3 mouth_tangent = path_tangent(at.tissue, path, mouth, tip.tangent);
  const Vector3 past = tip.position - at.tissue.position(path.vertices[mouth]);
  const bool before = mouth_tangent.dot(past) < 0 && tip.tangent.dot(past) < 0;
  return before && !noticed_inside(at.tissue, tip.position);
}

bool is_beyond(const InsertionView& at, const Path& path) {
  const CurvePoint tip = at.needle.tip();
  return tip.tangent.dot(tip.position - at.tissue.position(path.end)) > 0;
}

// Drops the last part of the path, which the tip has been pulled out of: the tip is through again, or in the part
// before.
void leave_last_part(const Transition& now, Path& path) {
  Insertion& state = now.state;
  const auto position = [&](int vertex) { return now.at.tissue.position(path.vertices[vertex]); };
  const int exit = path.last_mouth() - 1;
  path.drop_part((position(exit) - position(exit - 1)).norm());
  leave_border(now);
  state.end_s = state.vertices[exit].s;
  change_phase(state, is_beyond(now.at, path) ? Phase::through : Phase::inside);
  state.tip = TipState{};
  state.touched = MaterialPoint{};
}

// The needle is out of the tissue.
void leave_path(const Transition& now, Path& path) {
  now.report(EventKind::withdrawal, now.at.tissue.region(path.vertices[path.last_mouth()]), 0);
  path.needle = -1;
  path.left = now.tick;
  forget(now.state);
}

BorderAhead ahead_of(const Transition& now, const Path& path) {
  const auto& border = now.scratch.located.obstacle;
  if (!border) return {};
  BorderAhead ahead = border_on_the_way(now.at, path, *border, height(now.at.tissue, *border, tip_of(now.at)));
  if (now.state.border == border->region) ahead.dimple = 0;  // it has let go
  return ahead;
}

// The end of the cut of a tip that has gone through a border with the cutting force (N): behind the tip by what yields
// ahead of it, in the region behind the border. The path ends on the border, in that region.
MaterialPoint end_behind(const Transition& now, const Path& path, double cutting) {
  const TissueView& tissue = now.at.tissue;
  const auto reach = [&](const MaterialPoint& from, const Vector3& to) {
    return trace_segment(tissue.mesh, tissue.x, from.tetrahedron, tissue.position(from), to, tissue.regions).end;
  };
  const MaterialPoint at_tip = reach(path.end, now.at.needle.tip().position);
  const double lag = cut_spring(now.at, path.end, now.state.tip.cut.creep, {}).lead(cutting);
  return reach(at_tip, tissue.position(at_tip) - lag * now.at.cutting_direction());
}

// The cut goes on behind a border, with its own force. Vertices that the tip laid on the border as it slid, and the
// path's end, were displaced by the dimple (beside_dimple()). With the dimple gone the path goes from the last vertex
// before it straight to the tip.
std::uint32_t go_through_border(const Transition& now, Path& path, const Obstacle& border) {
  constexpr double kBeside = 0.05;  // of the dimple's depth
  const TissueView& tissue = now.at.tissue;
  const std::size_t least = static_cast<std::size_t>(path.last_mouth()) + 1;
  while (path.vertices.size() > least &&
         beside_dimple(now.at, path, now.scratch, path.vertices.back()).norm() > kBeside * border.dimple_before)
    path.vertices.pop_back();
  // Vertices of the straight piece take over the traction of those before them.
  now.state.last_alongside = std::min(now.state.last_alongside, static_cast<int>(path.vertices.size()) - 1);
  const int behind = tissue.borders.surface(border.region).beyond(border.at);
  path.end = {behind, barycentric(tissue.mesh, tissue.x, behind, tissue.position(border.material))};
  cut_beside_border(now.at, path, border, now.state.tip);
  now.state.tip.contact.creep = now.state.tip.cut.creep = {};
  path.end = end_behind(now, path, now.state.tip.cut.along);
  path.tail = 0;
  const MaterialPoint& last = path.vertices.back();
  const std::uint32_t flags =
      lay_vertices(now, path, last.tetrahedron, tissue.position(last), tissue.position(path.end));
  now.state.border = -1;
  return flags | grow(now, path, path.end.tetrahedron, -1);
}

// The tip punctures a border, presses on it, slides along it or leaves it.
std::uint32_t meet_border(const Transition& now, Path& path, const Obstacle& obstacle) {
  const TissueView& tissue = now.at.tissue;
  Insertion& state = now.state;
  const Surface& surface = tissue.borders.surface(obstacle.region);
  const int start = path.end.tetrahedron;
  const Vector3 from = tissue.position(path.end);
  // A tip that was under way to the border in this tick bears its cut and the contact together.
  if (state.tip.contact.along > 0) press_on_border(now.at, obstacle, state.tip);
  const bool crushed = state.tip.contact.along > 0 && is_crushed(tissue.mesh, tissue.x, obstacle.patch.points);
  if (now.scratch.puncturing || crushed) {
    if (state.border < 0) now.report(EventKind::contact, obstacle.region, state.tip.contact.along);
    const double puncture_force = tissue.border(obstacle.material, obstacle.region).puncture_force;
    now.report(EventKind::crossing, obstacle.region,
               force_along_needle(now.at, obstacle, puncture_force, state.tip.contact.along));
    return go_through_border(now, path, obstacle);
  }
  // The closest point is that of the tip's projection on the contact plane: a tip behind a thin layer is nearer to the
  // layer's other side. What the spring along the border yields is no slip.
  const Vector3& n = obstacle.at.normal;
  const Vector3 tip = now.at.needle.tip().position,
                slid = tip + obstacle.compliance_along * state.tip.contact.across + obstacle.crept_along;
  const Vector3 on_plane = slid - n.dot(slid - tissue.position(obstacle.material)) * n;
  const SurfacePoint under = surface.closest(tissue.x, on_plane);
  const Vector3 off_rim = on_plane - under.position - under.distance * under.normal;
  const bool beside = off_rim.norm() > kContactMargin;
  if (state.tip.contact.along > 0 && !beside) {
    if (state.border < 0) now.report(EventKind::contact, obstacle.region, state.tip.contact.along);
    state.border = obstacle.region;
    return slide(now, path, surface.material(under));
  }
  if (!beside && now.at.cutting_direction().dot(tip - from) <= 0) {
    leave_border(now);
    return 0;
  }
  if (state.tip.contact.along > 0) cut_beside_border(now.at, path, obstacle, state.tip);
  const std::uint32_t flags = grow(now, path, start, -1, ahead_of(now, path));
  if (state.border != obstacle.region || (tissue.position(path.end) - from).norm() > kBlocked) return flags;
  // The straight line cuts a corner of the region without pressing on it: the end follows the tip along the surface.
  const SurfacePoint foot = surface.closest(tissue.x, tip);
  const std::uint32_t followed = slide(now, path, surface.material(foot));
  if (foot.distance <= kContactMargin) return flags | followed;
  return flags | followed | grow(now, path, path.end.tetrahedron, -1, ahead_of(now, path));
}

// The path's end after a tick inside: the border that holds it, growth, exit.
std::uint32_t advance_end(const Transition& now, Path& path) {
  Insertion& state = now.state;
  const auto& obstacle = now.scratch.located.obstacle;
  const bool beyond = is_beyond(now.at, path);
  if (state.phase == Phase::through) return go_through(now, path, beyond);
  if (obstacle && (obstacle->under || state.tip.contact.along > 0)) return meet_border(now, path, *obstacle);
  leave_border(now);

  const bool cuts = now.scratch.cutting || now.at.tissue.interaction(path.end).cutting_force == 0;
  std::uint32_t flags = 0;
  if (!path.exited && beyond && cuts) {
    const int region = now.at.tissue.region(path.end);
    flags = grow(now, path, path.end.tetrahedron, -1, ahead_of(now, path));
    if (path.exited) now.report(EventKind::exit, region, state.tip.cut.along);
  } else if (path.exited && beyond) {
    now.report(EventKind::exit, now.at.tissue.region(path.end), 0);
  }
  if (path.exited) change_phase(state, beyond ? Phase::through : Phase::inside);
  return flags;
}

// Measured from the walls on the corrected needle, not on its free motion.
void measure_depth(const Transition& now) {
  Insertion& state = now.state;
  state.depth = 0;
  if (state.path < 0) return;
  const Path& path = now.paths[state.path];
  const NeedleView& needle = now.at.needle;
  const Vector3 tip_tangent = needle.tip().tangent;
  const auto place = [&](const MaterialPoint& point, const Vector3& tangent, double guess) {
    return project_on_curve(needle, now.at.tissue.position(point), tangent, guess);
  };
  const auto wall = [&](int vertex) {
    return wall_advance(now.at, path, state, vertex) + place(path.vertices[vertex],
                                                             path_tangent(now.at.tissue, path, vertex, tip_tangent),
                                                             state.vertices[vertex].s);
  };
  double end = needle.model.length;
  if (path.exited) {
    const double exit =
        exit_advance(now.at, path, state) + place(path.end, end_tangent(now.at.tissue, path, tip_tangent), state.end_s);
    end = std::clamp(exit, 0.0, end);  // a needle across its path meets the plane of the exit anywhere
  }
  double air = 0;
  for (const int exit : path.exits) {
    const auto of = [&](int vertex) { return std::clamp(wall(vertex), 0.0, end); };
    air += std::max(0.0, of(exit + 1) - of(exit));
  }
  state.depth = std::max(0.0, end - std::max(0.0, wall(0)) - air);
}

std::uint32_t change_state(const Transition& now) {
  if (now.state.path < 0) {
    leave_contact_or_puncture(now);
    return open_where_found(now);
  }
  Path& path = now.paths[now.state.path];
  if (now.scratch.located.reentered) {
    if (now.scratch.located.far_end) path.turn_round();
    path.needle = now.at.needle_index;
    now.report(EventKind::reentry, now.at.tissue.region(path.vertices[0]), 0);
  }
  while (is_withdrawn(now.at, path, now.state)) {
    const int mouth = path.last_mouth();
    if (mouth == 0) {
      leave_path(now, path);
      return 0;
    }
    now.report(EventKind::withdrawal, now.at.tissue.region(path.vertices[mouth]), 0);
    leave_last_part(now, path);
    if (now.state.phase == Phase::through) return 0;
  }
  const std::uint32_t flags = advance_end(now, path);
  return flags | open_where_found(now);
}

}  // namespace

void Transition::report(EventKind kind, int region, double force) const {
  report(kind, region, force, at.needle.tip().position);
}

void Transition::report(EventKind kind, int region, double force, const Vector3& position) const {
  if (events.size() == events.capacity()) return;
  events.push_back({tick, at.needle_index, kind, region, position, force});
}

std::uint32_t insertion_transitions(const Transition& now) {
  const std::uint32_t flags = change_state(now);
  if (!tear_path(now)) leave_path(now, now.paths[now.state.path]);
  if (const auto& skin = now.scratch.located.hub; skin && skin->bears == 0 && now.state.hub.along > 0)
    now.report(EventKind::hub, skin->region, now.state.hub.along,
               curve_point(now.at.needle.model, now.at.needle.shape, 0).position);
  measure_depth(now);
  return flags;
}

std::optional<ContactPatch> patch_ahead(const InsertionView& at, const Insertion& state, std::span<const Path> paths,
                                        double distance) {
  const TissueView& tissue = at.tissue;
  if (state.phase == Phase::inside) {
    const Path& path = paths[static_cast<std::size_t>(state.path)];
    if (!tissue.borders.any() || path.exited) return std::nullopt;
    const Vector3 end = tissue.position(path.end);
    const auto border = state.border >= 0 ? std::optional(BorderPlace{state.border, end})
                                          : first_border(tissue, path, end + distance * at.cutting_direction());
    if (!border) return std::nullopt;
    return border_ahead(at, border->region, border->place, state).patch;
  }
  if (state.phase != Phase::free && state.phase != Phase::through) return std::nullopt;
  const CurvePoint tip = at.needle.tip();
  if (!tissue.surface.near(tissue.x, tip.position, distance)) return std::nullopt;
  const auto entry = tissue.surface.entry(tissue.x, tip.position, tip.position + distance * tip.tangent);
  if (!entry) return std::nullopt;
  const MaterialPoint centre = tissue.surface.material(*entry);
  const double d = at.parameters.outer_diameter;
  return make_contact_patch(tissue, tissue.surface, centre,
                            tissue.contact_radius(centre, d, tissue.disc_load(centre, d, 0, 0)), d);
}

int tetrahedron_ahead(const InsertionView& at, const InsertionScratch& scratch, const Insertion& state,
                      std::span<const Path> paths, double distance) {
  const bool cuts = state.phase == Phase::inside && scratch.located.tip.in_tail;
  if (!cuts && !(touches(state) && scratch.located.obstacle)) return -1;
  const MaterialPoint& start = cuts ? paths[state.path].end : scratch.located.obstacle->material;
  const Vector3 from = at.tissue.position(start), to = from + distance * at.cutting_direction();
  return trace_segment(at.tissue.mesh, at.tissue.x, start.tetrahedron, from, to).end.tetrahedron;
}

}  // namespace acus
