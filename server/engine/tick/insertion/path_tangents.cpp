// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/tick/insertion/path_tangents.h"

#include <cassert>
#include <cmath>

namespace acus {

namespace {

// A last vertex this close to the end of its path (in spacings) is one place with it.
constexpr double kEndClearance = 0.1;
// Cosine of the largest angle between a path and the needle in it.
constexpr double kLeastAlongNeedle = 0.5;
// Square of the sine below which a path against the needle lies to no side of it.
constexpr double kNoSide = 1e-12;

Vector3 young_direction(const Vector3& along, const Vector3& needle_tangent, double spacing) {
  assert(spacing > 0);
  const double share = 2 * along.norm() / spacing;
  if (share >= 1) return along.normalized();
  return ((1 - share) * needle_tangent + share * along.stableNormalized()).normalized();
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
  const Vector3 after =
      ends ? here : vertex < last ? tissue.position(path.vertices[vertex + 1]) : tissue.position(path.end);
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

}  // namespace acus
