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
  Corners(const std::array<int, 3>& nodes, const Matrix3X& x)
      : a(x.col(nodes[0])), b(x.col(nodes[1])), c(x.col(nodes[2])) {}
  Vector3 area_normal() const { return (b - a).cross(c - a); }
};

}  // namespace

Surface::Surface(const TetrahedralMesh& mesh)
    : mesh_(mesh), triangles_(mesh.surface), owners_(mesh.surface_tetrahedron) {
  index_nodes();
}

Surface::Surface(const TetrahedralMesh& mesh, std::span<const int> regions, int region) : mesh_(mesh) {
  // Nodes of the face opposite to node k, counter-clockwise seen from node k: from the other side of the face, that of
  // the neighbour, they are clockwise, and seen from the tetrahedron outside of the region they must be the former.
  constexpr int kFaces[4][3] = {{1, 3, 2}, {0, 2, 3}, {0, 3, 1}, {0, 1, 2}};
  for (int t = 0; t < static_cast<int>(regions.size()); ++t) {
    if (regions[t] == region) continue;
    for (int k = 0; k < 4; ++k) {
      const int neighbour = mesh.neighbours[t][k];
      if (neighbour < 0 || regions[neighbour] != region) continue;
      const auto& nodes = mesh.tetrahedra[t];
      triangles_.push_back({nodes[kFaces[k][0]], nodes[kFaces[k][1]], nodes[kFaces[k][2]]});
      owners_.push_back(t);
    }
  }
  index_nodes();
}

void Surface::index_nodes() {
  if (empty()) return;
  node_triangles_.resize(static_cast<std::size_t>(mesh_.node_count()));
  for (int t = 0; t < triangle_count(); ++t)
    for (int node : triangles_[t]) node_triangles_[node].push_back(t);
  for (int i = 0; i < mesh_.node_count(); ++i)
    if (!node_triangles_[i].empty()) nodes_.push_back(i);
}

bool Surface::near(const Matrix3X& x, const Vector3& p, double margin) const {
  if (nodes_.empty()) return false;
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
    const Vector3 n = Corners(triangles_[t], x).area_normal();
    if (n.dot(facing) > std::numbers::sqrt2 / 2 * n.norm() * facing.norm()) sum += n;
  }
  return sum.normalized();
}

SurfacePoint Surface::make_point(const Matrix3X& x, int triangle, const Eigen::Vector3d& weights,
                                 const Vector3& query) const {
  SurfacePoint point;
  point.triangle = triangle;
  point.weights = weights;
  const Vector3 facing = Corners(triangles_[triangle], x).area_normal();
  Vector3 normal = Vector3::Zero();
  for (int k = 0; k < 3; ++k) {
    const int node = triangles_[triangle][k];
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
  for (int t = 0; t < static_cast<int>(triangles_.size()); ++t) {
    const Corners c(triangles_[t], x);
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
  for (int t = 0; t < static_cast<int>(triangles_.size()); ++t) {
    const Corners c(triangles_[t], x);
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
  m.tetrahedron = owners_[point.triangle];
  const auto& nodes = mesh_.tetrahedra[m.tetrahedron];
  for (int k = 0; k < 3; ++k) {
    const int node = triangles_[point.triangle][k];
    m.weights[std::find(nodes.begin(), nodes.end(), node) - nodes.begin()] = point.weights[k];
  }
  return m;
}

int Surface::beyond(const SurfacePoint& point) const {
  const int owner = owners_[point.triangle];
  const auto& face = triangles_[point.triangle];
  const auto& nodes = mesh_.tetrahedra[owner];
  for (int k = 0; k < 4; ++k)
    if (std::find(face.begin(), face.end(), nodes[k]) == face.end()) return mesh_.neighbours[owner][k];
  return -1;
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

namespace {

bool in_box(const TetrahedralMesh& mesh, const Matrix3X& x, int tetrahedron, const Vector3& p) {
  const auto& node = mesh.tetrahedra[tetrahedron];
  const auto a = x.col(node[0]), b = x.col(node[1]), c = x.col(node[2]), d = x.col(node[3]);
  for (int i = 0; i < 3; ++i) {
    if (p[i] < std::min(std::min(a[i], b[i]), std::min(c[i], d[i]))) return false;
    if (p[i] > std::max(std::max(a[i], b[i]), std::max(c[i], d[i]))) return false;
  }
  return true;
}

bool is_upright(const TetrahedralMesh& mesh, const Matrix3X& x, int tetrahedron) {
  const auto& node = mesh.tetrahedra[tetrahedron];
  const Vector3 origin = x.col(node[0]);
  const Vector3 a = x.col(node[1]) - origin, b = x.col(node[2]) - origin, c = x.col(node[3]) - origin;
  return a.dot(b.cross(c)) > 0;
}

}  // namespace

int find_tetrahedron(const TetrahedralMesh& mesh, const Matrix3X& x, const Vector3& p) {
  for (int t = 0; t < mesh.tetrahedron_count(); ++t)
    if (in_box(mesh, x, t, p) && is_upright(mesh, x, t) && barycentric(mesh, x, t, p).minCoeff() >= 0) return t;
  return -1;
}

Trace trace_segment(const TetrahedralMesh& mesh, const Matrix3X& x, int start, const Vector3& from, const Vector3& to,
                    std::span<const int> regions, int came_from) {
  constexpr int kMaxSteps = 256;
  constexpr double kInside = -1e-10;
  Trace trace;
  trace.end = {start, barycentric(mesh, x, start, to)};
  int previous = came_from;
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
    if (face < 0) break;
    const int next = mesh.neighbours[t][face];
    const bool changes = next >= 0 && !regions.empty() && regions[next] != regions[t];
    if (next < 0 || changes) {
      trace.left = next < 0;
      trace.next = next;
      const double s = std::clamp(soonest, 0.0, 1.0);
      trace.end.weights = barycentric(mesh, x, t, from + s * (to - from));
      return trace;
    }
    previous = t;
    trace.end = {next, barycentric(mesh, x, next, to)};
  }
  // Lost among flat tetrahedra, or farther than any needle goes in a tick: it stays where it got to.
  trace.end.weights = trace.end.weights.cwiseMax(0.0);
  trace.end.weights /= trace.end.weights.sum();
  return trace;
}

}  // namespace acus
