// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/models/geometry/triangle.h"

#include <algorithm>

namespace acus {
namespace {

// Barycentric weights of the point of triangle (a, b, c) closest to p, by the regions of Ericson, "Real-Time Collision
// Detection", 5.1.5.
Eigen::Vector3d closest_weights(const Vector3& p, const Vector3& a, const Vector3& b, const Vector3& c) {
  const Vector3 ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0 && d2 <= 0) return {1, 0, 0};
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0 && d4 <= d3) return {0, 1, 0};
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0 && d5 <= d6) return {0, 0, 1};
  double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return {1 - d1 / (d1 - d3), d1 / (d1 - d3), 0};
  double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return {1 - d2 / (d2 - d6), 0, d2 / (d2 - d6)};
  double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    const double w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    return {0, 1 - w, w};
  }
  // All three are positive, except by rounding in a triangle that is nearly a line: its point must not leave it.
  va = std::max(va, 0.0), vb = std::max(vb, 0.0), vc = std::max(vc, 0.0);
  const double sum = va + vb + vc;
  if (!(sum > 0)) return {1, 0, 0};
  return {va / sum, vb / sum, vc / sum};
}

}  // namespace

TrianglePoint closest_on_triangle(const Vector3& p, const Vector3& a, const Vector3& b, const Vector3& c) {
  const Eigen::Vector3d w = closest_weights(p, a, b, c);
  return {w, (w[0] * a + w[1] * b + w[2] * c - p).squaredNorm()};
}

std::optional<TriangleCrossing> cross_triangle(const Vector3& from, const Vector3& way, const Vector3& a,
                                               const Vector3& b, const Vector3& c) {
  const Vector3 ab = b - a, ac = c - a, n = ab.cross(ac);
  const double approach = -n.dot(way);
  if (!(approach > 0)) return std::nullopt;  // parallel, or from inside out
  const double s = n.dot(from - a) / approach;
  if (!(s >= 0 && s <= 1)) return std::nullopt;
  constexpr double kThin = 1e-10;  // sine of the angle between two edges, of which rounding is 1e-16
  const double area2 = n.squaredNorm();
  if (!(area2 > kThin * kThin * ab.squaredNorm() * ac.squaredNorm())) return std::nullopt;
  const Vector3 p = from + s * way;
  const double wb = n.dot((p - a).cross(ac)) / area2, wc = n.dot(ab.cross(p - a)) / area2;
  // A hair's breadth of overlap, so that no segment slips through between two triangles.
  constexpr double kSlack = 1e-9;
  if (!(wb >= -kSlack && wc >= -kSlack && wb + wc <= 1 + kSlack)) return std::nullopt;
  return TriangleCrossing{s, {1 - wb - wc, wb, wc}};
}

}  // namespace acus
