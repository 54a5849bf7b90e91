// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/tick/insertion/material_direction.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "server/engine/math/rotation.h"

namespace acus {

namespace {

// Share of a material line's stretch that goes along the direction, below which the tissue is too crushed to follow.
constexpr double kLeastAlongLine = 0.5;
// What is found is looked for anew from there, until it hardly changes.
constexpr int kRounds = 3;

struct Line {
  Vector3 at_rest, now;
};

Vector3 rest_position(const TissueView& tissue, const MaterialPoint& p) {
  return material_position(tissue.mesh, tissue.mesh.nodes, p);
}

// The point that lies `way` from a place of the tissue at rest, or where the tissue ends on the way there.
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
