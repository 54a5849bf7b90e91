// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/tick/insertion/transitions/tearing.h"

#include <algorithm>
#include <cmath>

#include "server/engine/tick/insertion/finding/obstacle.h"
#include "server/engine/tick/insertion/finding/tip_place.h"
#include "server/engine/tick/insertion/held_place.h"
#include "server/engine/tick/insertion/spring_memory.h"
#include "server/engine/tick/insertion/tip_laws.h"
#include "server/engine/tick/insertion/transitions/vertex_order.h"

namespace acus {

namespace {

// Share of the strength from which a place tears.
constexpr double kAtStrength = 1 - 1e-6;
// Speeds of a tear above which it has begun, and below which it has ended.
constexpr double kBegins = 1e-4, kEnds = 1e-5;  // m/s
// Cosine of the largest angle between a tip that tears and its path ahead, where that is longer than this (in
// spacings).
constexpr double kMostKink = 0.866, kLeastOldCut = 0.1;

// What tears fastest.
struct Fastest {
  double way = 0;       // m
  double force = 0;     // N
  MaterialPoint place;  // of the path
};

// m, world, across the needle; `force` on the needle.
Vector3 torn_way(const HeldPlace& place, const Vector3& force, const Vector3& needle_tangent) {
  if (force.isZero()) return Vector3::Zero();
  const Vector3 direction = force.stableNormalized();
  const double torn = -direction.dot(place.apart + place.compliance * force);
  return torn > 0 ? Vector3(-torn * (direction - needle_tangent.dot(direction) * needle_tangent)) : Vector3::Zero();
}

bool is_at_strength(const HeldPlace& place, const Vector3& force) {
  return force.norm() > kAtStrength * place.strength;
}

// A vertex of the path, or its end: -1. False if it has come to where the tissue ends.
bool move_point(const TissueView& tissue, Path& path, int vertex, const Vector3& way) {
  if (way.isZero()) return true;
  const bool end = vertex < 0;
  MaterialPoint& point = end ? path.end : path.vertices[vertex];
  const Vector3 to = tissue.position(point) + way;
  if (end ? path.exited : is_rim(path, vertex)) {
    point = tissue.surface.material(tissue.surface.closest(tissue.x, to));
    return true;
  }
  const Reached reached = reach_to(tissue, point, to, true);
  point = reached.end;
  return !reached.left;
}

void note(const Vector3& way, const Vector3& force, const MaterialPoint& place, Fastest& fastest) {
  if (way.norm() > fastest.way) fastest = {way.norm(), force.norm(), place};
}

void tear_shaft(const Transition& now, Path& path, Fastest& fastest) {
  const InsertionView& at = now.at;
  const TissueView& tissue = at.tissue;
  const int last = static_cast<int>(path.vertices.size()) - 1;
  const auto& shaft = now.scratch.located.shaft;
  for (std::size_t k = shaft.size(); k-- > 0;) {  // from the tip, so that numbers before it stay
    const ShaftPoint& point = shaft[k];
    if (point.vertex > last) continue;
    const MaterialPoint vertex = path.vertices[point.vertex];
    if (std::isinf(tissue.interaction(vertex).tear_strength)) continue;
    const CurvePoint needle = curve_point(at.needle.model, at.needle.shape, point.s);
    const HeldPlace place =
        held_vertex(at, vertex, point, needle.position, beside_dimple(at, path, now.scratch, vertex),
                    now.state.vertices[point.vertex].contact.creep);
    const Vector3 force = borne_by_path(tissue, vertex, now.state.vertices[point.vertex].contact.across);
    if (!is_at_strength(place, force)) continue;
    const Vector3 way = torn_way(place, force, needle.tangent);
    const bool inside = move_point(tissue, path, point.vertex, way);
    if (point.vertex == last && path.exited) move_point(tissue, path, -1, way);
    note(way, force, vertex, fastest);
    if (!inside) remove_vertex(path, now.state, point.vertex);
  }
}

// A tip that tears away from its path leaves the old cut ahead: the path ends at the tip.
void leave_old_cut(const InsertionView& at, const TipPlace& tip, Path& path, Insertion& state) {
  if (tip.behind < 0) return;
  const TissueView& tissue = at.tissue;
  const MaterialPoint &behind = path.vertices[tip.behind], &next = tip.next < 0 ? path.end : path.vertices[tip.next];
  const Vector3 place = tissue.position(TissuePoint{behind, next, tip.point.u});
  const Vector3 old_cut = tissue.position(next) - place;
  const bool beside =
      old_cut.norm() > kLeastOldCut * path.spacing && at.needle.tip().tangent.dot(old_cut) < kMostKink * old_cut.norm();
  if (!beside) return;
  path.end = reach_to(tissue, behind, place).end;
  path.tail = (tissue.position(path.end) - tissue.position(behind)).norm();
  path.vertices.resize(static_cast<std::size_t>(tip.behind) + 1);
  path.exited = false;
  state.end_s = at.needle.model.length;
}

// The tip's sideways rows hold it to one point of the path, or to a place between two, which share the way. False if it
// was torn out of the tissue.
bool tear_tip(const Transition& now, Path& path, Fastest& fastest) {
  const TissueView& tissue = now.at.tissue;
  const TipPlace& tip = now.scratch.located.tip;
  const int count = static_cast<int>(path.vertices.size());
  if (tip.point.a.tetrahedron < 0 || tip.next >= count || tip.behind >= count) return true;
  HeldPlace place = held_tip(now.at, tip, now.state.tip.contact.creep);
  place.apart -= tip.tangent.dot(place.apart) * tip.tangent;
  const Vector3 force = borne_by_path(tissue, tip.point.a, now.state.tip.contact.across);
  if (!is_at_strength(place, force)) return true;
  const Vector3 way = torn_way(place, force, now.at.needle.tip().tangent);
  const double u = tip.behind < 0 ? 1 : tip.point.u, shares = (1 - u) * (1 - u) + u * u;
  note(way, force, tip.next < 0 ? path.end : path.vertices[tip.next], fastest);
  if (u < 1) move_point(tissue, path, tip.behind, (1 - u) / shares * way);
  const bool inside = move_point(tissue, path, tip.next, u / shares * way);
  if (!inside && tip.next < 0) return false;
  if (!way.isZero()) leave_old_cut(now.at, tip, path, now.state);
  return true;
}

}  // namespace

bool tear_path(const Transition& now) {
  Insertion& state = now.state;
  const auto tears = [](const Interaction& law) { return !std::isinf(law.tear_strength); };
  if (state.path < 0 || std::ranges::none_of(now.at.tissue.interactions, tears)) return true;
  Path& path = now.paths[state.path];
  Fastest fastest;
  bool inside = true;
  // On a border, the tip's sideways force is friction along it.
  if (state.phase == Phase::inside && state.border < 0 && state.tip.contact.along == 0)
    inside = tear_tip(now, path, fastest);
  tear_shaft(now, path, fastest);
  const double speed = fastest.way / now.at.needle.h;
  const bool tears_on = speed > kBegins;
  if (tears_on && !state.tearing)
    now.report(EventKind::tear, now.at.tissue.region(fastest.place), fastest.force,
               now.at.tissue.position(fastest.place));
  if (tears_on || speed < kEnds) state.tearing = tears_on;
  if (fastest.way > 0 && inside) keep_order(now, path);
  return inside;
}

}  // namespace acus
