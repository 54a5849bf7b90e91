// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/models/geometry/area_in_ball.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace acus {

namespace {

using Vector2 = Eigen::Vector2d;

double cross(const Vector2& p, const Vector2& q) { return p.x() * q.y() - p.y() * q.x(); }

// Signed area between the directions of p and q, of a circle of radius r around the origin.
double sector(const Vector2& p, const Vector2& q, double r) { return r * r / 2 * std::atan2(cross(p, q), p.dot(q)); }

// Signed area of the triangle (origin, p, q) within that circle.
double within_circle(const Vector2& p, const Vector2& q, double r) {
  const Vector2 way = q - p;
  const double a = way.squaredNorm(), b = p.dot(way), root = b * b - a * (p.squaredNorm() - r * r);
  if (a == 0) return 0;
  const double in = (-b - std::sqrt(std::max(0.0, root))) / a, out = (-b + std::sqrt(std::max(0.0, root))) / a;
  if (root <= 0 || in >= 1 || out <= 0) return sector(p, q, r);
  // An end within the circle has no sector beside it, whose angle rounding would choose at the centre.
  const Vector2 enters = in > 0 ? Vector2(p + in * way) : p, leaves = out < 1 ? Vector2(p + out * way) : q;
  return (in > 0 ? sector(p, enters, r) : 0) + cross(enters, leaves) / 2 + (out < 1 ? sector(leaves, q, r) : 0);
}

}  // namespace

// The ball's circle in the plane of the triangle, edge by edge.
double area_in_ball(const Vector3& a, const Vector3& b, const Vector3& c, const Vector3& centre, double radius) {
  const Vector3 across = (b - a).cross(c - a);
  const Vector3 normal = across.stableNormalized(), along = (b - a).stableNormalized();
  const double height = normal.dot(centre - a), r2 = radius * radius - height * height;
  if (across.isZero(0) || r2 <= 0) return 0;
  const Vector3 beside = normal.cross(along);
  const auto in_plane = [&](const Vector3& p) { return Vector2(along.dot(p - centre), beside.dot(p - centre)); };
  const std::array<Vector2, 3> corners{in_plane(a), in_plane(b), in_plane(c)};
  const double r = std::sqrt(r2);
  double area = 0;
  for (std::size_t k = 0; k < 3; ++k) area += within_circle(corners[k], corners[(k + 1) % 3], r);
  return std::max(0.0, area);
}

}  // namespace acus
