// SPDX-License-Identifier: GPL-3.0-or-later
// The point of a triangle that is closest to another, and where a segment crosses it. A triangle (a, b, c) is seen
// counter-clockwise from outside; its weights are barycentric, those of a, b and c.
#pragma once

#include <optional>

#include "server/engine/math/types.h"

namespace acus {

struct TrianglePoint {
  Eigen::Vector3d weights;  // >= 0
  double distance2;         // m^2, to p
};
// The distance is not a number, or infinite, where a coordinate is.
TrianglePoint closest_on_triangle(const Vector3& p, const Vector3& a, const Vector3& b, const Vector3& c);

struct TriangleCrossing {
  double s;  // in [0, 1], along the segment
  Eigen::Vector3d weights;
};
// Where the segment from + s way, s in [0, 1], crosses the triangle from outside to inside. Nothing crosses a triangle
// with a coordinate that is not finite, or one so thin that rounding decides where it faces.
std::optional<TriangleCrossing> cross_triangle(const Vector3& from, const Vector3& way, const Vector3& a,
                                               const Vector3& b, const Vector3& c);

}  // namespace acus
