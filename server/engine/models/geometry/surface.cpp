// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/models/geometry/surface.h"

#include <algorithm>
#include <cassert>
#include <limits>
#include <numbers>

#include "server/engine/models/geometry/area_in_ball.h"

namespace acus {

namespace {

// Triangles in a cluster: few enough to look at all of them, enough for boxes to cost less.
constexpr int kClusterTriangles = 16;
// Of squares of distances to triangles that meet where a point is closest to both.
constexpr double kAsClose = 1e-9;

struct Corners {
  Vector3 a, b, c;
  Corners(const std::array<int, 3>& nodes, const Matrix3X& x)
      : a(x.col(nodes[0])), b(x.col(nodes[1])), c(x.col(nodes[2])) {}
  Vector3 area_normal() const { return (b - a).cross(c - a); }
};

// Within 45 degrees.
bool face_alike(const Vector3& a, const Vector3& b) { return a.dot(b) > std::numbers::sqrt2 / 2 * a.norm() * b.norm(); }

// How far coordinates as large as these may be off by rounding (m), with a wide margin.
double rounding(const Vector3& a, const Vector3& b) {
  return 1e-12 * std::max(a.cwiseAbs().maxCoeff(), b.cwiseAbs().maxCoeff());
}

// Of a triangle beside a point of a surface, how much it counts for the normal there: nothing where it is the back of a
// thin sheet, which faces away and lies under the point; all behind the crest of a sharp edge.
double belongs(const Corners& c, const Vector3& normal, const SurfacePoint& point, double radius) {
  const double faces = std::clamp(4 * normal.dot(point.normal) + 3, 0.0, 1.0);  // all within 120 degrees
  if (faces == 1) return 1;
  const Eigen::Vector3d w = closest_on_triangle(point.position, c.a, c.b, c.c).weights;
  const double under = point.normal.dot(point.position - (w[0] * c.a + w[1] * c.b + w[2] * c.c));
  return std::max(faces, std::clamp(1 - 4 * under / radius, 0.0, 1.0));
}

// A square of a distance (m^2) that is not above that from p to any point in the box, as rounded. Not a number where
// nothing can be said.
double least_distance2(const Bounds& box, const Vector3& p) {
  const double slack = rounding(box.low, box.high) + rounding(p, p);
  const Vector3 gap = (box.low - p).cwiseMax(p - box.high).array() - slack;
  return (1 - 1e-12) * gap.cwiseMax(0.0).squaredNorm();
}

// Whether the segment from + s way, s in [0, 1], has no point in the box: one of the axes of the box, or of those
// across it and the segment, separates them (Ericson, "Real-Time Collision Detection", 5.3.3). The box is grown by more
// than cross_triangle() lets a segment pass beside a triangle.
bool misses(const Bounds& box, const Vector3& from, const Vector3& way) {
  const double slack = rounding(box.low, box.high) + rounding(from, from + way);
  const Vector3 half = (0.5 + 1e-3) * (box.high - box.low) + Vector3::Constant(slack);
  const Vector3 h = way / 2, m = from + h - (box.low + box.high) / 2, span = h.cwiseAbs();
  if ((m.array().abs() > half.array() + span.array()).any()) return true;
  const Vector3 across = m.cross(h);
  return std::abs(across.x()) > half.y() * span.z() + half.z() * span.y() ||
         std::abs(across.y()) > half.z() * span.x() + half.x() * span.z() ||
         std::abs(across.z()) > half.x() * span.y() + half.y() * span.x();
}

}  // namespace

Surface::Surface(const TetrahedralMesh& mesh)
    : mesh_(mesh), sharp_edges_(true), triangles_(mesh.surface), owners_(mesh.surface_tetrahedron) {
  index_nodes();
}

Surface::Surface(const TetrahedralMesh& mesh, std::span<const int> regions, int region)
    : mesh_(mesh), sharp_edges_(false) {
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
  for (const auto& triangle : triangles_) nodes_.insert(nodes_.end(), triangle.begin(), triangle.end());
  std::ranges::sort(nodes_);
  nodes_.erase(std::unique(nodes_.begin(), nodes_.end()), nodes_.end());
  index_corners();
  put_outermost_first();
  clusters_ = Clusters(mesh_.nodes, triangles_, kClusterTriangles);
  for (int cluster = 0; cluster < clusters_.count(); ++cluster)
    rest_bounds_.push_back(clusters_.bounds(mesh_.nodes, cluster));
}

// Around a node, triangles belong together that smooth edges join, one after the other: so normals are continuous
// across every smooth edge, and a triangle's own does not choose.
void Surface::index_corners() {
  std::vector<std::vector<int>> around(static_cast<std::size_t>(mesh_.node_count()));
  for (int t = 0; t < triangle_count(); ++t)
    for (const int node : triangles_[t]) around[node].push_back(t);
  const auto normal = [&](int t) { return Corners(triangles_[t], mesh_.nodes).area_normal(); };
  const auto joined = [&](int s, int t, int node) {
    const auto shares = [&](int other) { return other != node && std::ranges::count(triangles_[t], other) > 0; };
    return std::ranges::any_of(triangles_[s], shares) && (!sharp_edges_ || face_alike(normal(s), normal(t)));
  };
  std::vector<std::vector<std::vector<int>>> groups(around.size());  // per node, each with its triangles in order
  for (const int node : nodes_) {
    std::vector<int>& left = around[node];
    while (!left.empty()) {
      std::vector<int>& group = groups[node].emplace_back(1, left.back());
      left.pop_back();
      for (std::size_t i = 0; i < group.size(); ++i) {
        const auto more = std::partition(left.begin(), left.end(), [&](int t) { return !joined(group[i], t, node); });
        group.insert(group.end(), more, left.end());
        left.erase(more, left.end());
      }
      std::ranges::sort(group);
    }
  }
  for (int t = 0; t < triangle_count(); ++t) {
    for (const int node : triangles_[t]) {
      const auto own = std::ranges::find_if(
          groups[node], [t](const std::vector<int>& group) { return std::ranges::binary_search(group, t); });
      corner_begin_.push_back(static_cast<int>(corner_triangles_.size()));
      corner_triangles_.insert(corner_triangles_.end(), own->begin(), own->end());
    }
  }
  corner_begin_.push_back(static_cast<int>(corner_triangles_.size()));
}

// The six nodes that span the box at rest, so that near() finds most points in it at once.
void Surface::put_outermost_first() {
  auto next = nodes_.begin();
  for (int k = 0; k < 6 && next != nodes_.end(); ++k) {
    const double sign = k < 3 ? 1 : -1;
    const auto outward = [&](int i) { return sign * mesh_.nodes(k % 3, i); };
    std::iter_swap(next, std::max_element(next, nodes_.end(), [&](int i, int j) { return outward(i) < outward(j); }));
    ++next;
  }
}

bool Surface::near(const Matrix3X& x, const Vector3& p, double margin) const {
  // A box that contains p continues doing so when it grows: often that of the first few nodes is enough.
  const std::span<const int> all = nodes_, first = all.first(std::min<std::size_t>(16, all.size()));
  Bounds box = bounds_of(x, first);
  if (box.contains(p, margin)) return true;
  box.add(bounds_of(x, all.subspan(first.size())));
  return box.contains(p, margin);
}

double Surface::largest_move(const Matrix3X& from, const Matrix3X& to) const {
  double largest2 = 0;
  for (const int node : nodes_) largest2 = std::max(largest2, (to.col(node) - from.col(node)).squaredNorm());
  return std::sqrt(largest2);
}

// Mean normal of the triangles that meet at a triangle's corner across no sharp edge: curved surfaces are smooth, and
// the faces of a box flat up to its edges.
Vector3 Surface::corner_normal(const Matrix3X& x, int triangle, int corner) const {
  const auto from = corner_triangles_.begin(), at = corner_begin_.begin() + 3 * triangle + corner;
  Vector3 sum = Vector3::Zero();
  for (auto t = from + at[0]; t != from + at[1]; ++t) sum += Corners(triangles_[*t], x).area_normal();
  return sum.normalized();
}

SurfacePoint Surface::make_point(const Matrix3X& x, int triangle, const Eigen::Vector3d& weights,
                                 const Vector3& query) const {
  SurfacePoint point;
  point.triangle = triangle;
  point.weights = weights;
  Vector3 normal = Vector3::Zero();
  for (int k = 0; k < 3; ++k) {
    const int node = triangles_[triangle][k];
    point.position += weights[k] * x.col(node);
    normal += weights[k] * corner_normal(x, triangle, k);
  }
  point.normal = normal.normalized();
  point.distance = point.normal.dot(query - point.position);
  return point;
}

std::optional<SurfacePoint> Surface::entry(const Matrix3X& x, const Vector3& a, const Vector3& b) const {
  TriangleCrossing first{std::numeric_limits<double>::infinity(), {}};
  int triangle = -1;
  const Vector3 way = b - a;
  for (int cluster = 0; cluster < clusters_.count(); ++cluster) {
    if (misses(bounds(x, cluster), a, way)) continue;
    for (const int t : clusters_.elements(cluster)) {
      const Corners c(triangles_[t], x);
      const auto crossing = cross_triangle(a, way, c.a, c.b, c.c);
      if (!crossing || crossing->s > first.s || (crossing->s == first.s && t > triangle)) continue;
      first = *crossing;
      triangle = t;
    }
  }
  if (triangle < 0) return std::nullopt;
  return make_point(x, triangle, first.weights, a);
}

// Looks at those of a cluster's triangles that count for one closer than `nearest`; as close and counting more; or
// likewise and of a lower number.
template <class Counts>
void Surface::look_for_closer(const Matrix3X& x, const Vector3& p, int cluster, const Counts& counts,
                              Nearest& nearest) const {
  for (const int t : clusters_.elements(cluster)) {
    const Corners c(triangles_[t], x);
    const double count = counts(c);
    if (!(count > 0)) continue;
    const TrianglePoint found = closest_on_triangle(p, c.a, c.b, c.c);
    if (!(found.distance2 < std::numeric_limits<double>::infinity())) continue;
    const double least = nearest.point.distance2, as_close = count == nearest.count ? 0 : kAsClose;
    const bool preferred = count > nearest.count || (count == nearest.count && t < nearest.triangle);
    if (preferred ? found.distance2 <= (1 + as_close) * least : found.distance2 < (1 - as_close) * least)
      nearest = {t, found, count};
  }
}

template <class Counts>
Surface::Nearest Surface::find_nearest(const Matrix3X& x, const Vector3& p, const Counts& counts) const {
  assert(!empty());
  Nearest nearest{0, {{1, 0, 0}, std::numeric_limits<double>::infinity()}, 0};
  // Boxes of so many clusters at a time: first the nearest one's triangles, then those of boxes that are no farther.
  constexpr int kBatch = 512;
  std::array<double, kBatch> least;
  for (int begin = 0; begin < clusters_.count(); begin += kBatch) {
    const int count = std::min(kBatch, clusters_.count() - begin);
    for (int i = 0; i < count; ++i) least[i] = clusters_.count() > 1 ? least_distance2(bounds(x, begin + i), p) : 0;
    const auto best = static_cast<int>(std::min_element(least.begin(), least.begin() + count) - least.begin());
    const auto may_have = [&](int i) { return !(least[i] > (1 + kAsClose) * nearest.point.distance2); };
    if (may_have(best)) look_for_closer(x, p, begin + best, counts, nearest);
    for (int i = 0; i < count; ++i)
      if (i != best && may_have(i)) look_for_closer(x, p, begin + i, counts, nearest);
  }
  return nearest;
}

SurfacePoint Surface::closest(const Matrix3X& x, const Vector3& p) const {
  const Nearest nearest = find_nearest(x, p, [](const Corners&) { return 1.0; });
  return make_point(x, nearest.triangle, nearest.point.weights, p);
}

SurfacePoint Surface::closest_facing(const Matrix3X& x, const Vector3& p, const Vector3& direction) const {
  const auto facing = [&](const Corners& c) { return c.area_normal().stableNormalized().dot(direction); };
  const Nearest nearest = find_nearest(x, p, facing);
  if (std::isinf(nearest.point.distance2)) return closest(x, p);
  return make_point(x, nearest.triangle, nearest.point.weights, p);
}

Vector3 Surface::mean_normal(const Matrix3X& x, const SurfacePoint& point, double radius) const {
  Vector3 sum = Vector3::Zero();
  for (int cluster = 0; cluster < clusters_.count(); ++cluster) {
    if (least_distance2(bounds(x, cluster), point.position) > radius * radius) continue;
    for (const int t : clusters_.elements(cluster)) {
      const Corners c(triangles_[t], x);
      const Vector3 normal = c.area_normal().stableNormalized();
      sum += belongs(c, normal, point, radius) * area_in_ball(c.a, c.b, c.c, point.position, radius) * normal;
    }
  }
  return sum.isZero(0) ? point.normal : sum.stableNormalized();
}

Vector3 Surface::normal(const Matrix3X& x, const SurfacePoint& point) const {
  return make_point(x, point.triangle, point.weights, point.position).normal;
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
    if (!(p[i] >= std::min(std::min(a[i], b[i]), std::min(c[i], d[i])))) return false;
    if (!(p[i] <= std::max(std::max(a[i], b[i]), std::max(c[i], d[i])))) return false;
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
  assert(mesh.clusters.count() > 0);
  int first = mesh.tetrahedron_count();
  for (int cluster = 0; cluster < mesh.clusters.count(); ++cluster) {
    const std::span<const int> tetrahedra = mesh.clusters.elements(cluster);
    if (tetrahedra.front() >= first) continue;
    if (mesh.clusters.count() > 1 && !mesh.clusters.bounds(x, cluster).contains(p)) continue;
    for (const int t : tetrahedra) {
      if (t >= first) break;
      if (in_box(mesh, x, t, p) && is_upright(mesh, x, t) && barycentric(mesh, x, t, p).minCoeff() >= 0) first = t;
    }
  }
  return first < mesh.tetrahedron_count() ? first : -1;
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
