// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/tick/insertion/finding/location.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "server/engine/state/needle/phase.h"
#include "server/engine/tick/insertion/finding/hub.h"
#include "server/engine/tick/insertion/finding/obstacle.h"
#include "server/engine/tick/insertion/finding/shaft_contact.h"
#include "server/engine/tick/insertion/finding/tip_place.h"
#include "server/engine/tick/insertion/owned_lengths.h"
#include "server/engine/tick/insertion/path_direction.h"
#include "server/engine/tick/insertion/path_wall.h"
#include "server/engine/tick/insertion/spring_memory.h"
#include "server/engine/tick/insertion/tip_laws.h"

namespace acus {

namespace {

struct Mouth {
  int path = -1;         // -1: none
  bool far_end = false;  // where the path left the tissue
};

// The nearest mouth of a path without a needle, within a needle's diameter of a place on the surface.
Mouth find_mouth(const InsertionView& at, const Vector3& place, std::span<const Path> paths,
                 std::span<const char> paths_taken) {
  Mouth nearest;
  double distance = at.parameters.outer_diameter;
  const auto consider = [&](int path, bool far_end, const MaterialPoint& mouth) {
    const double apart = (at.tissue.position(mouth) - place).norm();
    if (apart > distance) return;
    distance = apart;
    nearest = {path, far_end};
  };
  for (int i = 0; i < static_cast<int>(paths.size()); ++i) {
    const Path& path = paths[i];
    if (path.empty() || path.needle >= 0 || paths_taken[i]) continue;
    consider(i, false, path.vertices[0]);
    if (path.exited) consider(i, true, path.end);
  }
  return nearest;
}

// Whether the tip is past an open mouth and moves inwards.
bool goes_into(const InsertionView& at, const Path& path, bool far_end, const Vector3& surface_normal) {
  const CurvePoint tip = at.needle.tip();
  const Vector3 past = tip.position - at.tissue.position(far_end ? path.end : path.vertices[0]);
  const Vector3 inwards =
      far_end ? Vector3(-end_tangent(at.tissue, path, -tip.tangent)) : path_tangent(at.tissue, path, 0, tip.tangent);
  return surface_normal.dot(past) < 0 && inwards.dot(past) > 0;
}

void pick_up(const InsertionView& at, const Mouth& mouth, std::span<const Path> paths, InsertionScratch& scratch) {
  scratch.located.reentered = true;
  scratch.located.far_end = mouth.far_end;
  enter(scratch.next, mouth.path, at.parameters.length);
  if (!mouth.far_end) return;
  scratch.turned = paths[mouth.path];
  scratch.turned.turn_round();
}

// The surface point ahead of the tip in this tick, if any. In contact it is the contact point of the last tick: the
// closest point to a tip in a pit may be on the pit's wall.
std::optional<SurfacePoint> find_surface(const InsertionView& at, const Insertion& state) {
  const Surface& surface = at.tissue.surface;
  if (state.phase == Phase::contact) return surface.closest(at.tissue.x, at.tissue.position(state.touched));
  const Vector3 before = at.needle.start_tip(), after = at.needle.tip().position;
  const double margin = kContactMargin + 2 * (after - before).norm();
  if (!surface.near(at.tissue.x, before, margin)) return std::nullopt;
  const auto entry = surface.entry(at.tissue.x, before, after);
  const SurfacePoint point = entry ? *entry : surface.closest(at.tissue.x, before);
  if (std::abs(point.distance) > margin) return std::nullopt;
  return point;
}

// The surface point ahead of a tip that is through, if any: one that faces the tip. The surface at the exit faces away.
std::optional<SurfacePoint> find_next_surface(const InsertionView& at, const Insertion& state) {
  const Surface& surface = at.tissue.surface;
  if (touches(state)) return surface.closest(at.tissue.x, at.tissue.position(state.touched));
  const CurvePoint tip = at.needle.tip();
  const Vector3 before = at.needle.start_tip();
  const double margin = kContactMargin + 2 * (tip.position - before).norm();
  if (!surface.near(at.tissue.x, before, margin)) return std::nullopt;
  const auto faces = [&](const SurfacePoint& point) { return point.normal.dot(tip.tangent) < 0; };
  const auto entry = surface.entry(at.tissue.x, before, tip.position + kContactMargin * tip.tangent);
  if (entry && faces(*entry)) return entry;
  const SurfacePoint closest = surface.closest(at.tissue.x, before);
  if (std::abs(closest.distance) > margin || !faces(closest)) return std::nullopt;
  return closest;
}

void locate_outside(const InsertionView& at, std::span<const Path> paths, std::span<char> paths_taken,
                    InsertionScratch& scratch) {
  const auto point = find_surface(at, scratch.next);
  if (!point) return;
  // An open mouth under the tip has no surface to push against.
  const Mouth mouth = find_mouth(at, point->position, paths, paths_taken);
  if (mouth.path >= 0) {
    if (!goes_into(at, paths[mouth.path], mouth.far_end, point->normal)) return;
    paths_taken[mouth.path] = 1;
    pick_up(at, mouth, paths, scratch);
    return;
  }
  scratch.located.obstacle = surface_ahead(at, *point, scratch.next);
}

// A vertex that was not alongside in the last tick takes over the traction of the one before it.
void take_over_traction(Insertion& next, std::span<const ShaftPoint> shaft) {
  double before = 0;
  for (const ShaftPoint& point : shaft) {
    VertexState& state = next.vertices[point.vertex];
    if (point.mouth) before = 0;
    if (point.vertex < next.first_alongside || point.vertex > next.last_alongside) {
      state.traction = before;
      state.contact.along = before * point.owned;
    }
    before = state.traction;
  }
}

// The last vertex alongside takes over the friction of the vertices that the tip has been pulled past.
void take_over_friction(Insertion& next, std::span<const ShaftPoint> shaft) {
  if (shaft.empty()) return;
  const ShaftPoint& last = shaft.back();
  if (last.vertex < next.first_alongside || last.vertex >= next.last_alongside || last.owned == 0) return;
  VertexState& state = next.vertices[last.vertex];
  for (int i = last.vertex + 1; i <= next.last_alongside; ++i) state.contact.along += next.vertices[i].contact.along;
  state.traction = state.contact.along / last.owned;
}

// The places of the path's vertices along the needle, and the vertices alongside.
void find_shaft_points(const InsertionView& at, const Path& path, InsertionScratch& scratch) {
  const double length = at.needle.model.length;
  const Vector3 tip_tangent = at.needle.tip().tangent;
  for (int i = 0; i < static_cast<int>(path.vertices.size()); ++i) {
    double& s = scratch.next.vertices[i].s;
    const Vector3 needle_tangent = curve_point(at.needle.model, at.needle.shape, s).tangent;
    const Vector3 tangent = along_needle(path_tangent(at.tissue, path, i, tip_tangent), needle_tangent);
    s = project_on_curve(at.needle, at.tissue.position(path.vertices[i]), tangent, s);
    if (s < 0 || s > length) continue;
    if (scratch.located.shaft.full()) {
      scratch.located.left_out = true;
    } else {
      scratch.located.shaft.push_back({.vertex = i,
                                       .s = s,
                                       .tangent = tangent,
                                       .mouth = i == 0 || path.air_behind(i - 1),
                                       .exit = path.air_behind(i)});
    }
  }
}

void locate_inside(const InsertionView& at, const Path& path, InsertionScratch& scratch) {
  const double length = at.needle.model.length;
  find_shaft_points(at, path, scratch);
  double& end_s = scratch.next.end_s;
  const Vector3 tangent = end_tangent(at.tissue, path, at.needle.tip().tangent);
  end_s = project_on_curve(at.needle, at.tissue.position(path.end), tangent, end_s);
  for (ShaftPoint& point : scratch.located.shaft)
    if (point.mouth || point.exit) point.advance = wall_advance(at, path, scratch.next, point.vertex);
  place_tip(at, path, scratch);
  find_border(at, path, scratch);
  const TipState& tip = scratch.next.tip;
  scratch.located.tip.lead = cut_spring(at, path.end, tip.cut.creep, scratch.located.tip.ahead).lead(tip.cut.along);
  const bool through = scratch.next.phase == Phase::through;
  const std::span<ShaftPoint> shaft{scratch.located.shaft.begin(), scratch.located.shaft.end()};
  const double end = through ? std::min(length, end_s) : length;
  scratch.located.tip.supported = share_length(shaft, end, !through);
  share_tearing(shaft, scratch.located.tip, through ? 0 : end_length(at, scratch.located.tip.point.a));
  scale_owned_lengths(at, path, scratch.next, shaft, end);
  if (!through) return;
  if (const auto point = find_next_surface(at, scratch.next))
    scratch.located.obstacle = surface_ahead(at, *point, scratch.next);
}

}  // namespace

void locate_insertion(const InsertionView& at, const Insertion& before, std::span<const Path> paths,
                      std::span<char> paths_taken, InsertionScratch& scratch) {
  scratch.next = before;
  if (at.tissue.relaxes()) forget_dimple(scratch.next);
  scratch.puncturing = scratch.cutting = false;
  scratch.located.reentered = scratch.located.far_end = scratch.located.left_out = false;
  scratch.located.obstacle.reset();
  scratch.located.shaft.clear();
  scratch.located.contacts.clear();
  scratch.located.tip = TipPlace{};
  if (scratch.next.path < 0) locate_outside(at, paths, paths_taken, scratch);
  if (scratch.next.path >= 0) locate_inside(at, scratch.path(paths), scratch);
  const Bounded<ShaftPoint>& shaft = scratch.located.shaft;
  take_over_traction(scratch.next, {shaft.begin(), shaft.end()});
  take_over_friction(scratch.next, {shaft.begin(), shaft.end()});
  if (at.tissue.relaxes()) relax_springs(at, before, scratch.next.path >= 0 ? &scratch.path(paths) : nullptr, scratch);
  scratch.next.first_alongside = shaft.empty() ? 0 : shaft.front().vertex;
  scratch.next.last_alongside = shaft.empty() ? -1 : shaft.back().vertex;
  find_shaft_contacts(at, scratch);
  find_hub(at, scratch.next.path >= 0 ? &scratch.path(paths) : nullptr, scratch);
}

}  // namespace acus
