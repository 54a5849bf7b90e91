// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/tick/insertion/path_wall.h"

#include <algorithm>
#include <cassert>
#include <optional>

#include "server/engine/tick/insertion/path_direction.h"
#include "server/engine/tick/insertion/tip_laws.h"

namespace acus {

namespace {

// In R, between a tip and what supports it.
constexpr double kFurthest = 3;

// The last vertex alongside, -1 if there is none; a path may have become shorter than the needle's part in it.
int last_alongside(const Path& path, const Insertion& state) {
  const int last = std::min(state.last_alongside, static_cast<int>(path.vertices.size()) - 1);
  return is_alongside(state, last) ? last : -1;
}

// Whether a border bears the tip at the end of its path.
bool on_border(const Insertion& state) { return state.border >= 0 && state.tip.contact.along > 0; }

// What the mesh lacks ahead of a tip at the end of its path: how far the tip is beyond it for that (m), and between
// which radii.
struct Ahead {
  double lead = 0;
  LoadRadii radii;
};

Ahead ahead_of_tip(const InsertionView& at, const MaterialPoint& end, const Insertion& state) {
  const double d = at.parameters.outer_diameter;
  if (on_border(state)) {
    const double f = state.tip.contact.along, below = (at.needle.start_tip() - at.tissue.start_position(end)).norm();
    const double f_w = at.tissue.disc_load(end, d, f, below, state.border);
    DimpleSpring dimple = at.tissue.dimple_spring(end, d, f_w, state.border);
    dimple.relax(at.tissue.relaxation_of(end, state.border), state.tip.contact.creep.along);
    return {dimple.depth(f), dimple.radii(f)};
  }
  const double f_c = at.tissue.interaction(end).cutting_force;
  return {cut_spring(at, end, state.tip.cut.creep, {}).lead(state.tip.cut.along), at.tissue.tip_radii(end, d, f_c)};
}

// The traction (N/m) of a vertex that would carry tissue along by as much at rest.
double traction_at_rest(const InsertionView& at, const MaterialPoint& vertex, const VertexState& state) {
  const double axial = at.tissue.axial_compliance(vertex, at.needle.model.diameter);
  if (axial == 0) return state.traction;
  const RelaxationStep& law = at.tissue.relaxation_of(vertex);
  return (state.traction + law.given.dot(state.contact.creep.along) / axial) / law.stiffening;
}

// b, of the forces of the last tick.
double carried_by_cut(const InsertionView& at, const Path& path, const Insertion& state, double to_tip) {
  const Vector3 end = at.tissue.start_position(path.end);
  const auto [springs, radii] = ahead_of_tip(at, path.end, state);
  if (springs == 0 || radii.resolved()) return 0;
  const Dent dent{Vector3::Zero(), Vector3::Zero(), radii};
  const double ahead = std::max(0.0, at.cutting_direction().dot(at.needle.start_tip() - end));
  const double lag = std::min(springs, ahead);
  return to_tip > lag ? lag * dent.share({to_tip - lag, 0, 0}) : to_tip;
}

// Of the last part, from its mouth to where the shaft or the tissue ends (m).
double last_length(const InsertionView& at, const Path& path, const Insertion& state) {
  const double end = path.exited ? std::min(at.needle.model.length, state.end_s) : at.needle.model.length;
  return std::max(0.0, end - state.vertices[path.last_mouth()].s);
}

// L (m) of the part that a vertex is in, if the needle leaves that by an exit.
std::optional<double> length_to_exit(const InsertionView& at, const Path& path, const Insertion& state, int vertex) {
  double begin = state.vertices[0].s;
  for (const int exit : path.exits) {
    if (vertex <= exit) return std::max(0.0, state.vertices[exit].s - begin);
    begin = state.vertices[exit + 1].s;
  }
  return is_out(at, path, state) ? std::optional(last_length(at, path, state)) : std::nullopt;
}

// Along the needle at its place s (m), and across it what brings `place` to it.
Vector3 move_to_needle(const InsertionView& at, const Vector3& place, double s, double advance) {
  const CurvePoint beside = curve_point(at.needle.model, at.needle.shape, s);
  const Vector3 apart = beside.position - place;
  return apart + (advance - beside.tangent.dot(apart)) * beside.tangent;
}

}  // namespace

double wall_advance(const InsertionView& at, const Path& path, const Insertion& state, int vertex) {
  if (!is_alongside(state, vertex)) return 0;
  const MaterialPoint& place = path.vertices[vertex];
  const double traction = traction_at_rest(at, place, state.vertices[vertex]);
  if (const auto L = length_to_exit(at, path, state, vertex))
    return at.tissue.surface_displacement(place, at.needle.model.diameter, -traction, *L);
  const double to_tip = at.needle.model.length - state.vertices[vertex].s,
               cut = carried_by_cut(at, path, state, to_tip);
  return cut + at.tissue.mouth_displacement(place, at.needle.model.diameter, -traction, std::max(0.0, to_tip - cut));
}

double exit_advance(const InsertionView& at, const Path& path, const Insertion& state) {
  assert(path.exited);
  const int last = last_alongside(path, state);
  if (last < path.last_mouth()) return 0;
  const double traction = traction_at_rest(at, path.vertices[last], state.vertices[last]);
  return at.tissue.surface_displacement(path.end, at.needle.model.diameter, -traction, last_length(at, path, state));
}

bool is_out(const InsertionView& at, const Path& path, const Insertion& state) {
  return path.exited && state.end_s + std::min(0.0, exit_advance(at, path, state)) <= at.needle.model.length;
}

Vector3 wall_move(const InsertionView& at, const Path& path, const Insertion& state, int vertex) {
  assert(is_alongside(state, vertex));
  return move_to_needle(at, at.tissue.position(path.vertices[vertex]), state.vertices[vertex].s,
                        wall_advance(at, path, state, vertex));
}

Vector3 exit_move(const InsertionView& at, const Path& path, const Insertion& state) {
  return move_to_needle(at, at.tissue.position(path.end), state.end_s, exit_advance(at, path, state));
}

// As place_tip() finds it, from the places along the needle.
TipWall tip_wall(const InsertionView& at, const Path& path, const Insertion& state) {
  const int mouth = path.last_mouth(), count = static_cast<int>(path.vertices.size());
  const double length = at.needle.model.length;
  int next = mouth;
  while (next < count && state.vertices[next].s <= length) ++next;
  const bool tail = next == count;
  const double next_s = tail ? state.end_s : state.vertices[next].s;
  TissuePoint point{tail ? path.end : path.vertices[next], {}, 0};
  if (state.tip.cut.along > 0 || on_border(state)) {
    point.a = path.end;
  } else if (next > mouth && length < next_s) {
    const double from_s = state.vertices[next - 1].s;
    point = {path.vertices[next - 1], point.a, (length - from_s) / (next_s - from_s)};
  }
  TipWall wall{at.tissue.position(point), Vector3::Zero(), ahead_of_tip(at, point.a, state).radii};
  const Vector3 apart = at.needle.tip().position - wall.place;
  const double most = kFurthest * wall.radii.outer, distance = apart.norm();
  wall.move = distance > most ? Vector3(most / distance * apart) : apart;
  return wall;
}

}  // namespace acus
