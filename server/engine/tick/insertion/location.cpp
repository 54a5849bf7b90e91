// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/tick/insertion/location.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "server/engine/state/phase.h"
#include "server/engine/tick/insertion/border_search.h"
#include "server/engine/tick/insertion/path_tangents.h"
#include "server/engine/tick/insertion/tip_place.h"

namespace acus {

namespace {

struct Mouth {
  int path = -1;         // -1: none
  bool far_end = false;  // the one where the path left the tissue
};

// The nearest mouth of a path without a needle within a needle's diameter of a place on the surface.
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

// Whether the tip is past an open mouth and goes inwards.
bool goes_into(const InsertionView& at, const Path& path, bool far_end, const Vector3& surface_normal) {
  const CurvePoint tip = at.needle.tip();
  const Vector3 past = tip.position - at.tissue.position(far_end ? path.end : path.vertices[0]);
  const Vector3 inwards = far_end ? Vector3(-end_tangent(at.tissue, path, -tip.tangent))
                                  : path_tangent(at.tissue, path, 0, tip.tangent);
  return surface_normal.dot(past) < 0 && inwards.dot(past) > 0;
}

void pick_up(const InsertionView& at, const Mouth& mouth, std::span<const Path> paths, InsertionWork& work) {
  work.located.reentered = true;
  work.located.far_end = mouth.far_end;
  enter(work.next, mouth.path, at.parameters.length);
  if (!mouth.far_end) return;
  work.turned = paths[mouth.path];
  work.turned.turn_round();
}

// The surface point that the tip meets in this tick, if any. In contact it is the one that the last tick left: what is
// closest to a tip in a pit may be its wall.
std::optional<SurfacePoint> find_surface(const InsertionView& at, const Insertion& memory) {
  const Surface& surface = at.tissue.surface;
  if (memory.phase == Phase::contact) return surface.closest(at.tissue.x, at.tissue.position(memory.touched));
  const Vector3 before = at.needle.start_tip(), after = at.needle.tip().position;
  const double margin = kContactMargin + 2 * (after - before).norm();
  if (!surface.near(at.tissue.x, before, margin)) return std::nullopt;
  const auto entry = surface.entry(at.tissue.x, before, after);
  const SurfacePoint point = entry ? *entry : surface.closest(at.tissue.x, before);
  if (std::abs(point.distance) > margin) return std::nullopt;
  return point;
}

// The surface point that a tip which is through meets in this tick, if any: one that faces it. Where it came out the
// surface faces away.
std::optional<SurfacePoint> find_next_surface(const InsertionView& at, const Insertion& memory) {
  const Surface& surface = at.tissue.surface;
  if (touches(memory)) return surface.closest(at.tissue.x, at.tissue.position(memory.touched));
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

Obstacle surface_obstacle(const InsertionView& at, const SurfacePoint& point) {
  Obstacle obstacle;
  obstacle.at = point;
  obstacle.material = at.tissue.surface.material(point);
  obstacle.region = at.tissue.region(obstacle.material);
  const double radius = at.tissue.contact_radius(obstacle.material, at.parameters.outer_diameter);
  obstacle.patch = make_contact_patch(at.tissue, obstacle.material, radius);
  obstacle.compliance = at.tissue.surface_compliance(obstacle.material, at.parameters.outer_diameter);
  obstacle.at.normal = obstacle.patch->normal;
  return obstacle;
}

void locate_outside(const InsertionView& at, std::span<const Path> paths, std::span<char> paths_taken,
                    InsertionWork& work) {
  const auto point = find_surface(at, work.next);
  if (!point) return;
  // An open mouth under the tip: no surface to push against.
  const Mouth mouth = find_mouth(at, point->position, paths, paths_taken);
  if (mouth.path >= 0) {
    if (!goes_into(at, paths[mouth.path], mouth.far_end, point->normal)) return;
    paths_taken[mouth.path] = 1;
    pick_up(at, mouth, paths, work);
    return;
  }
  work.located.obstacle = surface_obstacle(at, *point);
}

// Vertices that were not alongside in the last tick are as strained as the one before them.
void take_over_traction(Insertion& next, std::span<const ShaftPoint> shaft) {
  double before = 0;
  for (const ShaftPoint& point : shaft) {
    VertexMemory& memory = next.vertices[point.vertex];
    if (point.mouth) before = 0;
    if (point.vertex < next.first_alongside || point.vertex > next.last_alongside) {
      memory.traction = before;
      memory.friction = before * point.owned;
    }
    before = memory.traction;
  }
}

// What the vertices bore that the tip has been pulled out past goes to the last one alongside, with their length.
void take_over_friction(Insertion& next, std::span<const ShaftPoint> shaft) {
  if (shaft.empty()) return;
  const ShaftPoint& last = shaft.back();
  if (last.vertex < next.first_alongside || last.vertex >= next.last_alongside || last.owned == 0) return;
  VertexMemory& memory = next.vertices[last.vertex];
  for (int i = last.vertex + 1; i <= next.last_alongside; ++i) memory.friction += next.vertices[i].friction;
  memory.traction = memory.friction / last.owned;
}

// Where the path's vertices stand along the needle, and those alongside.
void find_shaft_points(const InsertionView& at, const Path& path, InsertionWork& work) {
  const double length = at.needle.model.length;
  const Vector3 tip_tangent = at.needle.tip().tangent;
  for (int i = 0; i < static_cast<int>(path.vertices.size()); ++i) {
    double& s = work.next.vertices[i].s;
    const Vector3 needle_tangent = curve_point(at.needle.model, at.needle.shape, s).tangent;
    const Vector3 tangent = along_needle(path_tangent(at.tissue, path, i, tip_tangent), needle_tangent);
    s = project_on_curve(at.needle, at.tissue.position(path.vertices[i]), tangent, s);
    if (s < 0 || s > length) continue;
    if (work.located.shaft.full()) {
      work.located.left_out = true;
    } else {
      work.located.shaft.push_back({i, s, 0, 0, tangent, i == 0 || path.air_behind(i - 1), path.air_behind(i)});
    }
  }
}

void locate_inside(const InsertionView& at, const Path& path, InsertionWork& work) {
  const double length = at.needle.model.length;
  find_shaft_points(at, path, work);
  double& end_s = work.next.end_s;
  const Vector3 tangent = end_tangent(at.tissue, path, at.needle.tip().tangent);
  end_s = project_on_curve(at.needle, at.tissue.position(path.end), tangent, end_s);
  place_tip(at, path, work);
  find_border(at, path, work);
  const bool through = work.next.phase == Phase::through;
  const std::span<ShaftPoint> shaft{work.located.shaft.begin(), work.located.shaft.end()};
  work.located.tip.held = share_length(shaft, through ? std::min(length, end_s) : length, !through);
  if (!through) return;
  if (const auto point = find_next_surface(at, work.next)) work.located.obstacle = surface_obstacle(at, *point);
}

}  // namespace

double share_length(std::span<ShaftPoint> shaft, double end, bool tip_holds) {
  assert(std::ranges::is_sorted(shaft, {}, &ShaftPoint::vertex));
  const auto count = static_cast<int>(shaft.size());
  for (int i = 0; i < count; ++i) {
    const double from = shaft[i].mouth ? shaft[i].s : i > 0 ? 0.5 * (shaft[i - 1].s + shaft[i].s) : 0;
    const double to = shaft[i].exit ? shaft[i].s : i + 1 < count ? 0.5 * (shaft[i].s + shaft[i + 1].s) : end;
    shaft[i].owned = shaft[i].held = std::max(0.0, to - from);
  }
  if (!tip_holds || shaft.empty() || shaft.back().exit) return 0;
  ShaftPoint& last = shaft.back();
  const double left = (end - last.s) / 2;
  last.held = std::max(0.0, last.held - left);
  return left;
}

void locate_insertion(const InsertionView& at, const Insertion& before, std::span<const Path> paths,
                      std::span<char> paths_taken, InsertionWork& work) {
  work.next = before;
  work.puncturing = work.cutting = false;
  work.located.reentered = work.located.far_end = work.located.left_out = false;
  work.located.obstacle.reset();
  work.located.shaft.clear();
  work.located.tip = TipPlace{};
  if (work.next.path < 0) locate_outside(at, paths, paths_taken, work);
  if (work.next.path >= 0) locate_inside(at, work.path(paths), work);
  const Bounded<ShaftPoint>& shaft = work.located.shaft;
  take_over_traction(work.next, {shaft.begin(), shaft.end()});
  take_over_friction(work.next, {shaft.begin(), shaft.end()});
  work.next.first_alongside = shaft.empty() ? 0 : shaft.front().vertex;
  work.next.last_alongside = shaft.empty() ? -1 : shaft.back().vertex;
}

}  // namespace acus
