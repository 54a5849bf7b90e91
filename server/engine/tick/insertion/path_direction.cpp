// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/tick/insertion/path_direction.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "server/engine/math/rotation.h"

namespace acus {

namespace {

// Distance from the end of the path (in spacings) below which the last vertex is one place with it.
constexpr double kEndClearance = 0.1;
// Cosine of the largest angle between a path and the needle in it.
constexpr double kLeastAlongNeedle = 0.5;
// Square of the sine below which a path that runs against the needle has no side.
constexpr double kNoSide = 1e-12;

Vector3 young_direction(const Vector3& along, const Vector3& needle_tangent, double spacing) {
  assert(spacing > 0);
  const double share = 2 * along.norm() / spacing;
  if (share >= 1) return along.normalized();
  return ((1 - share) * needle_tangent + share * along.stableNormalized()).normalized();
}

// Cosine between a material line and the direction below which the tissue is too crushed to follow the line.
constexpr double kLeastAlongLine = 0.5;
// Fixed-point iterations; after three the direction hardly changes.
constexpr int kRounds = 3;

struct Line {
  Vector3 at_rest, now;
};

Vector3 rest_position(const TissueView& tissue, const MaterialPoint& p) {
  return material_position(tissue.mesh, tissue.mesh.nodes, p);
}

// The point at `way` (m) from a place of the tissue at rest, or where the tissue ends before.
MaterialPoint go_at_rest(const TissueView& tissue, const MaterialPoint& place, const Vector3& way) {
  const Vector3 from = rest_position(tissue, place);
  return trace_segment(tissue.mesh, tissue.mesh.nodes, place.tetrahedron, from, from + way).end;
}

Line line_along(const TissueView& tissue, const MaterialPoint& middle, const Vector3& direction) {
  const MaterialPoint back = go_at_rest(tissue, middle, -kAlong * direction);
  const MaterialPoint front = go_at_rest(tissue, middle, kAlong * direction);
  return {rest_position(tissue, front) - rest_position(tissue, back), tissue.position(front) - tissue.position(back)};
}

// Of the four lines beside the place that are parallel to `direction` at rest.
Line sum_of_lines(const TissueView& tissue, const MaterialPoint& place, const Vector3& direction) {
  Vector3 across[2];
  perpendicular_basis(tissue.mesh, direction, across[0], across[1]);
  Line sum{Vector3::Zero(), Vector3::Zero()};
  for (const Vector3& a : across)
    for (const double way : {-kBeside, kBeside}) {
      const Line line = line_along(tissue, go_at_rest(tissue, place, way * a), direction);
      sum.at_rest += line.at_rest;
      sum.now += line.now;
    }
  return sum;
}

}  // namespace

int holding_vertices(const Path& path) {
  const auto count = static_cast<int>(path.vertices.size());
  return count > path.last_mouth() + 1 && path.tail < kEndClearance * path.spacing ? count - 1 : count;
}

Vector3 path_tangent(const TissueView& tissue, const Path& path, int vertex, const Vector3& needle_tangent) {
  const int last = static_cast<int>(path.vertices.size()) - 1;
  assert(vertex >= 0 && vertex <= last);
  const Vector3 here = tissue.position(path.vertices[vertex]);
  const bool begins = vertex == 0 || path.air_behind(vertex - 1), ends = path.air_behind(vertex);
  const Vector3 before = begins ? here : tissue.position(path.vertices[vertex - 1]);
  const Vector3 after = ends            ? here
                        : vertex < last ? tissue.position(path.vertices[vertex + 1])
                                        : tissue.position(path.end);
  return young_direction(after - before, needle_tangent, path.spacing);
}

Vector3 end_tangent(const TissueView& tissue, const Path& path, const Vector3& needle_tangent) {
  const int last = holding_vertices(path) - 1;
  assert(last >= 0);
  const Vector3 along = tissue.position(path.end) - tissue.position(path.vertices[last]);
  return young_direction(along, needle_tangent, path.spacing);
}

Vector3 along_needle(const Vector3& path, const Vector3& needle) {
  const double along = path.dot(needle);
  if (along >= kLeastAlongNeedle) return path;
  const Vector3 across = path - along * needle;
  if (across.squaredNorm() < kNoSide) return needle;
  return kLeastAlongNeedle * needle + std::sqrt(1 - kLeastAlongNeedle * kLeastAlongNeedle) * across.stableNormalized();
}

Vector3 direction_at_rest(const TissueView& tissue, const MaterialPoint& place, const Vector3& direction) {
  assert(std::abs(direction.norm() - 1) < 1e-9);
  Vector3 found = direction;
  for (int i = 0; i < kRounds; ++i) {
    const Line sum = sum_of_lines(tissue, place, found);
    if (sum.at_rest.isZero() || sum.now.isZero()) return direction;
    found = (rotation_between(sum.now, sum.at_rest) * direction).normalized();
  }
  return found;
}

Vector3 way_through_material(const TissueView& tissue, const MaterialPoint& place, const Vector3& direction,
                             double way) {
  assert(way > 0);
  const Vector3 at_rest = direction_at_rest(tissue, place, direction);
  const Vector3 from = tissue.position(place), rest_from = rest_position(tissue, place);
  Vector3 moved = way * direction;
  double rest_way = way;
  for (int i = 0; i < kRounds; ++i) {
    const MaterialPoint end = go_at_rest(tissue, place, rest_way * at_rest);
    const double beyond = rest_way - (rest_position(tissue, end) - rest_from).norm();  // where the tissue has ended
    const Vector3 there = tissue.position(end) + std::max(0.0, beyond) * direction - from;
    const double along = direction.dot(there);
    if (!(along > kLeastAlongLine * there.norm())) return way * direction;
    moved = way / along * there;
    rest_way *= way / along;
  }
  return moved;
}

}  // namespace acus
