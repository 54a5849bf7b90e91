// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/models/surface.h"

#include <algorithm>
#include <limits>
#include <numbers>

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
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return {1 - d1 / (d1 - d3), d1 / (d1 - d3), 0};
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return {1 - d2 / (d2 - d6), 0, d2 / (d2 - d6)};
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    const double w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    return {0, 1 - w, w};
  }
  const double sum = va + vb + vc;
  return {va / sum, vb / sum, vc / sum};
}

struct Corners {
  Vector3 a, b, c;
  Corners(const TetrahedralMesh& mesh, const Matrix3X& x, int triangle)
      : a(x.col(mesh.surface[triangle][0])), b(x.col(mesh.surface[triangle][1])), c(x.col(mesh.surface[triangle][2])) {}
  Vector3 area_normal() const { return (b - a).cross(c - a); }
};

}  // namespace

Surface::Surface(const TetrahedralMesh& mesh) : mesh_(mesh), node_triangles_(static_cast<std::size_t>(mesh.node_count())) {
  for (int t = 0; t < static_cast<int>(mesh.surface.size()); ++t)
    for (int node : mesh.surface[t]) node_triangles_[node].push_back(t);
  for (int i = 0; i < mesh.node_count(); ++i)
    if (!node_triangles_[i].empty()) nodes_.push_back(i);
}

bool Surface::near(const Matrix3X& x, const Vector3& p, double margin) const {
  Vector3 low = x.col(nodes_.front()), high = low;
  for (int i : nodes_) {
    low = low.cwiseMin(x.col(i));
    high = high.cwiseMax(x.col(i));
  }
  return (p.array() >= low.array() - margin).all() && (p.array() <= high.array() + margin).all();
}

// Mean normal of the triangles around a node that face within 45 degrees of `facing`: curved surfaces are smooth, and
// the faces of a box flat up to its edges.
Vector3 Surface::corner_normal(const Matrix3X& x, int node, const Vector3& facing) const {
  Vector3 sum = Vector3::Zero();
  for (int t : node_triangles_[node]) {
    const Vector3 n = Corners(mesh_, x, t).area_normal();
    if (n.dot(facing) > std::numbers::sqrt2 / 2 * n.norm() * facing.norm()) sum += n;
  }
  return sum.normalized();
}

SurfacePoint Surface::make_point(const Matrix3X& x, int triangle, const Eigen::Vector3d& weights,
                                 const Vector3& query) const {
  SurfacePoint point;
  point.triangle = triangle;
  point.weights = weights;
  const Vector3 facing = Corners(mesh_, x, triangle).area_normal();
  Vector3 normal = Vector3::Zero();
  for (int k = 0; k < 3; ++k) {
    const int node = mesh_.surface[triangle][k];
    point.position += weights[k] * x.col(node);
    normal += weights[k] * corner_normal(x, node, facing);
  }
  point.normal = normal.normalized();
  point.distance = point.normal.dot(query - point.position);
  return point;
}

std::optional<SurfacePoint> Surface::entry(const Matrix3X& x, const Vector3& a, const Vector3& b) const {
  double first = std::numeric_limits<double>::infinity();
  int triangle = -1;
  Eigen::Vector3d weights;
  const Vector3 d = b - a;
  for (int t = 0; t < static_cast<int>(mesh_.surface.size()); ++t) {
    const Corners c(mesh_, x, t);
    const Vector3 n = c.area_normal();
    const double approach = -n.dot(d);
    if (approach <= 0) continue;  // parallel, or from inside out
    const double s = n.dot(a - c.a) / approach;
    if (s < 0 || s > 1 || s >= first) continue;
    const Vector3 p = a + s * d;
    const double area2 = n.squaredNorm();
    const double wb = n.dot((p - c.a).cross(c.c - c.a)) / area2, wc = n.dot((c.b - c.a).cross(p - c.a)) / area2;
    // A hair's breadth of overlap, so that no segment slips through between two triangles.
    constexpr double kSlack = 1e-9;
    if (wb < -kSlack || wc < -kSlack || wb + wc > 1 + kSlack) continue;
    first = s;
    triangle = t;
    weights = {1 - wb - wc, wb, wc};
  }
  if (triangle < 0) return std::nullopt;
  return make_point(x, triangle, weights, a);
}

SurfacePoint Surface::closest(const Matrix3X& x, const Vector3& p) const {
  double best = std::numeric_limits<double>::infinity();
  int triangle = 0;
  Eigen::Vector3d weights(1, 0, 0);
  for (int t = 0; t < static_cast<int>(mesh_.surface.size()); ++t) {
    const Corners c(mesh_, x, t);
    const Eigen::Vector3d w = closest_weights(p, c.a, c.b, c.c);
    const double distance2 = (w[0] * c.a + w[1] * c.b + w[2] * c.c - p).squaredNorm();
    if (distance2 < best) {
      best = distance2;
      triangle = t;
      weights = w;
    }
  }
  return make_point(x, triangle, weights, p);
}

MaterialPoint Surface::material(const SurfacePoint& point) const {
  MaterialPoint m;
  m.tetrahedron = mesh_.surface_tetrahedron[point.triangle];
  const auto& nodes = mesh_.tetrahedra[m.tetrahedron];
  for (int k = 0; k < 3; ++k) {
    const int node = mesh_.surface[point.triangle][k];
    m.weights[std::find(nodes.begin(), nodes.end(), node) - nodes.begin()] = point.weights[k];
  }
  return m;
}

Eigen::Vector4d barycentric(const TetrahedralMesh& mesh, const Matrix3X& x, int tetrahedron, const Vector3& p) {
  const auto& node = mesh.tetrahedra[tetrahedron];
  const Vector3 origin = x.col(node[0]);
  const Vector3 a = x.col(node[1]) - origin, b = x.col(node[2]) - origin, c = x.col(node[3]) - origin;
  const Vector3 q = p - origin;
  const double six_volume = a.dot(b.cross(c));
  // A flat element has no coordinates; its middle is as good as any point of it.
  if (!(std::abs(six_volume) > 1e-12 * a.norm() * b.norm() * c.norm())) return Eigen::Vector4d::Constant(0.25);
  const double wa = q.dot(b.cross(c)) / six_volume, wb = a.dot(q.cross(c)) / six_volume,
               wc = a.dot(b.cross(q)) / six_volume;
  return {1 - wa - wb - wc, wa, wb, wc};
}

Trace trace_segment(const TetrahedralMesh& mesh, const Matrix3X& x, int start, const Vector3& from, const Vector3& to) {
  constexpr int kMaxSteps = 256;
  constexpr double kInside = -1e-10;
  Trace trace;
  trace.end = {start, barycentric(mesh, x, start, to)};
  int previous = -1;
  for (int step = 0; step < kMaxSteps; ++step) {
    const int t = trace.end.tetrahedron;
    const Eigen::Vector4d at_end = trace.end.weights;
    if (at_end.minCoeff() >= kInside) return trace;

    // The face through which the segment leaves first: where a weight falls to zero soonest.
    const Eigen::Vector4d at_start = barycentric(mesh, x, t, from);
    int face = -1;
    double soonest = std::numeric_limits<double>::infinity();
    for (int k = 0; k < 4; ++k) {
      const int neighbour = mesh.neighbours[t][k];
      if (at_end[k] >= kInside || (neighbour >= 0 && neighbour == previous)) continue;
      const double fall = at_start[k] - at_end[k];
      const double s = fall > 0 ? at_start[k] / fall : 0;
      if (s < soonest) soonest = s, face = k;
    }
    if (face < 0) return trace;
    const int next = mesh.neighbours[t][face];
    if (next < 0) {
      trace.left = true;
      const double s = std::clamp(soonest, 0.0, 1.0);
      trace.end.weights = barycentric(mesh, x, t, from + s * (to - from));
      return trace;
    }
    previous = t;
    trace.end = {next, barycentric(mesh, x, next, to)};
  }
  return trace;
}

}  // namespace acus
