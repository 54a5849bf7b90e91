// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/tick/insertion/tearing.h"

#include <algorithm>
#include <cmath>

#include "server/engine/tick/insertion/obstacle.h"
#include "server/engine/tick/insertion/shaft_rows.h"
#include "server/engine/tick/insertion/spring_memory.h"
#include "server/engine/tick/insertion/tip_laws.h"
#include "server/engine/tick/insertion/tip_place.h"
#include "server/engine/tick/insertion/vertex_order.h"

namespace acus {

namespace {

// Share of its strength from which a place has a threshold.
constexpr double kNear = 0.5;
// Time constant with which a force above the strength falls.
constexpr double kFall = 5e-3;  // s
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

// m, world, across the needle. `apart`: the needle from the place, less what is no force of the spring; c in m/N, F on
// the needle.
Vector3 torn_way(const Vector3& apart, double compliance, const Vector3& force, const Vector3& needle_tangent) {
  if (force.isZero()) return Vector3::Zero();
  const Vector3 direction = force.stableNormalized();
  const double torn = -direction.dot(apart + compliance * force);
  return torn > 0 ? Vector3(-torn * (direction - needle_tangent.dot(direction) * needle_tangent)) : Vector3::Zero();
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
    const Vector3 force = borne_by_path(tissue, vertex, now.state.vertices[point.vertex].lateral);
    const double strength = tear_strength(tissue, vertex, point.supported);
    if (!(force.norm() > kAtStrength * strength)) continue;
    const CreptAcross spring =
        crept_across(tissue, vertex,
                     tissue.relaxes() ? &now.state.memory->vertices[static_cast<std::size_t>(point.vertex)] : nullptr);
    const double compliance =
        beside_compliance(tissue, vertex, at.needle.model.diameter, point.supported) / spring.stiffening;
    const CurvePoint needle = curve_point(at.needle.model, at.needle.shape, point.s);
    const Vector3 apart =
        needle.position - tissue.position(vertex) - beside_dimple(at, path, now.scratch, vertex) + spring.crept;
    const Vector3 way = torn_way(apart, compliance, force, needle.tangent);
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
  const Vector3 force = borne_by_path(tissue, tip.point.a, now.state.tip.lateral);
  const double strength = tip_tear_strength(now.at, tip);
  if (!(force.norm() > kAtStrength * strength)) return true;
  const CreptAcross spring = crept_across(tissue, tip.point.a, tissue.relaxes() ? &now.state.memory->tip : nullptr);
  const double compliance = tip_lateral_compliance(now.at, tip.point.a, tip.supported) / spring.stiffening;
  const CurvePoint needle = now.at.needle.tip();
  const Vector3 apart = needle.position - tissue.position(tip.point) + spring.crept;
  const Vector3 way = torn_way(apart - tip.tangent.dot(apart) * tip.tangent, compliance, force, needle.tangent);
  const double u = tip.behind < 0 ? 1 : tip.point.u, shares = (1 - u) * (1 - u) + u * u;
  note(way, force, tip.next < 0 ? path.end : path.vertices[tip.next], fastest);
  if (u < 1) move_point(tissue, path, tip.behind, (1 - u) / shares * way);
  const bool inside = move_point(tissue, path, tip.next, u / shares * way);
  if (!inside && tip.next < 0) return false;
  if (!way.isZero()) leave_old_cut(now.at, tip, path, now.state);
  return true;
}

}  // namespace

std::optional<TearLimit> tear_limit(const InsertionView& at, const HeldPlace& place, double strength,
                                    const Vector3& last) {
  if (std::isinf(strength)) return std::nullopt;
  const auto across = [&](const Vector3& vector) {
    const Vector3 borne = borne_by_path(at.tissue, place.material, vector);
    return Vector3(borne - place.tangent.dot(borne) * place.tangent);
  };
  const Vector3 apart = across(place.apart);
  const double before = across(last).norm(), distance = apart.norm();
  if (!(std::max(before, distance / place.compliance) > kNear * strength) || distance == 0) return std::nullopt;
  return TearLimit{-apart / distance, strength + std::max(0.0, before - strength) * std::exp(-at.needle.h / kFall)};
}

double tear_strength(const TissueView& tissue, const MaterialPoint& vertex, double supported) {
  return tissue.interaction(vertex).tear_strength * std::max(supported, kLeastSupported);
}

double tip_tear_strength(const InsertionView& at, const TipPlace& tip) {
  const MaterialPoint& place = tip.point.a;
  const double strength = at.tissue.interaction(place).tear_strength;
  if (std::isinf(strength)) return strength;
  return strength * at.tissue.lateral_compliance(place, at.needle.model.diameter) /
         tip_lateral_compliance(at, place, tip.supported);
}

Vector3 borne_by_path(const TissueView& tissue, const MaterialPoint& place, const Vector3& vector) {
  const auto face = tissue.border_face(place);
  return face ? Vector3(vector - face->normal.dot(vector) * face->normal) : vector;
}

bool tear_path(const Transition& now) {
  Insertion& state = now.state;
  const auto tears = [](const Interaction& law) { return !std::isinf(law.tear_strength); };
  if (state.path < 0 || std::ranges::none_of(now.at.tissue.interactions, tears)) return true;
  Path& path = now.paths[state.path];
  Fastest fastest;
  bool inside = true;
  // On a border, the tip's sideways force is friction along it.
  if (state.phase == Phase::inside && state.border < 0 && state.tip.contact == 0) inside = tear_tip(now, path, fastest);
  tear_shaft(now, path, fastest);
  const double h = now.at.needle.h;
  if (fastest.way > kBegins * h && !state.tearing)
    now.report(EventKind::tear, now.at.tissue.region(fastest.place), fastest.force,
               now.at.tissue.position(fastest.place));
  if (fastest.way > kBegins * h)
    state.tearing = true;
  else if (fastest.way < kEnds * h)
    state.tearing = false;
  if (fastest.way > 0 && inside) keep_order(now, path);
  return inside;
}

}  // namespace acus
