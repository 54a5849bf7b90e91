// SPDX-License-Identifier: GPL-3.0-or-later
// Where a needle's tip meets a surface of the tissue, in the current configuration x (3 x nodes, m, world): the boundary
// of the whole, or the boundary of a region inside.
#pragma once

#include <optional>
#include <span>

#include "server/engine/models/geometry/clusters.h"
#include "server/engine/models/geometry/material_point.h"
#include "server/engine/models/geometry/triangle.h"

namespace acus {

struct SurfacePoint {
  int triangle = -1;
  Eigen::Vector3d weights = Eigen::Vector3d::Zero();  // barycentric in the triangle
  Vector3 position = Vector3::Zero();                 // m
  Vector3 normal = Vector3::Zero();                   // unit, outward, smooth across edges: shallow ones, or all
  double distance = 0;                                // m, from the query point, along the normal
};

// Closest points on and crossings through a set of triangles, each a face of the mesh. Queries read the boxes around
// clusters of triangles and look at the few triangles that matter; answers are those of a look at all of them. Triangles
// with a coordinate that is not finite are left out.
class Surface {
 public:
  // The mesh's boundary; outside is where there is no tissue. Its edges are sharp where they are above 45 degrees at
  // rest.
  explicit Surface(const TetrahedralMesh& mesh);
  // The faces that a region shares with others; outside is the rest of the tissue. `regions` per tetrahedron; without
  // them the surface is empty. No edge is sharp: a mesh that does not follow a border has it in steps.
  Surface(const TetrahedralMesh& mesh, std::span<const int> regions, int region);

  bool empty() const { return triangles_.empty(); }
  int triangle_count() const { return static_cast<int>(triangles_.size()); }

  // Box around the surface, grown by `margin`: whether p lies in it. Costs at most one pass over its nodes; the cheap
  // first question while a needle is far away.
  bool near(const Matrix3X& x, const Vector3& p, double margin) const;

  // The first crossing from outside to inside of the segment from a to b, or nothing. Of several triangles crossed at
  // once, that of the lowest number.
  std::optional<SurfacePoint> entry(const Matrix3X& x, const Vector3& a, const Vector3& b) const;

  // The closest point to p; the surface must not be empty. Of several triangles as close, that of the lowest number; a
  // corner of triangle 0 if no distance is a number.
  SurfacePoint closest(const Matrix3X& x, const Vector3& p) const;
  // The same among the triangles that face within 90 degrees of a direction (unit), or among all if none does; past an
  // edge, where those of either face are as close, one that faces it most.
  SurfacePoint closest_facing(const Matrix3X& x, const Vector3& p, const Vector3& direction) const;

  // Unit, outward: the mean of the triangles within `radius` (m) of a point of the surface, each by its area there
  // (the back of a thin sheet left out). It turns without a jump as the point moves, over sharp edges, too.
  Vector3 mean_normal(const Matrix3X& x, const SurfacePoint& point, double radius) const;

  // The longest way of its nodes from one configuration to another (m).
  double largest_move(const Matrix3X& from, const Matrix3X& to) const;

  // Outward, unit, at a point of the surface in the configuration x: as SurfacePoint::normal.
  Vector3 normal(const Matrix3X& x, const SurfacePoint& point) const;

  // The same point as one of the tetrahedron that owns it: on the boundary the one there is, inside the one outside of
  // the region.
  MaterialPoint material(const SurfacePoint& point) const;
  // The tetrahedron on the other side of the point's triangle, or -1 on the boundary of the mesh.
  int beyond(const SurfacePoint& point) const;

 private:
  struct Nearest {
    int triangle;
    TrianglePoint point;
    double count;  // how much it counts
  };

  void index_nodes();
  void index_corners();
  void put_outermost_first();
  // Those at rest, which contact patches ask for many times a tick, are kept.
  Bounds bounds(const Matrix3X& x, int cluster) const {
    return x.data() == mesh_.nodes.data() ? rest_bounds_[cluster] : clusters_.bounds(x, cluster);
  }
  template <class Counts>
  void look_for_closer(const Matrix3X& x, const Vector3& p, int cluster, const Counts& counts, Nearest& nearest) const;
  template <class Counts>
  Nearest find_nearest(const Matrix3X& x, const Vector3& p, const Counts& counts) const;
  SurfacePoint make_point(const Matrix3X& x, int triangle, const Eigen::Vector3d& weights, const Vector3& query) const;
  Vector3 corner_normal(const Matrix3X& x, int triangle, int corner) const;

  const TetrahedralMesh& mesh_;
  bool sharp_edges_;
  std::vector<std::array<int, 3>> triangles_;      // nodes, counter-clockwise seen from outside
  std::vector<int> owners_;                        // tetrahedron per triangle
  std::vector<int> nodes_;                         // of the triangles; outermost ones first
  Clusters clusters_;                              // of the triangles
  std::vector<Bounds> rest_bounds_;                // of the clusters
  std::vector<int> corner_begin_;                  // per triangle and corner, in corner_triangles_; one more at the end
  std::vector<int> corner_triangles_;              // that meet there, across no sharp edge
};

// Follows the straight segment from `from` (inside tetrahedron `start`) to `to` through the tetrahedra it crosses, at
// most to the first face where the region changes, if `regions` (per tetrahedron) are given. `came_from` is the
// tetrahedron that the segment has just left, which it does not go back to.
struct Trace {
  MaterialPoint end;           // the last point reached: `to`, or where the segment leaves the tissue or its region
  bool left = false;           // the segment leaves through the boundary
  int next = -1;               // the tetrahedron of another region at which it stopped
};
Trace trace_segment(const TetrahedralMesh& mesh, const Matrix3X& x, int start, const Vector3& from, const Vector3& to,
                    std::span<const int> regions = {}, int came_from = -1);

// The first tetrahedron of positive volume that p lies in, or -1: the one of the lowest number. None holds a p with a
// coordinate that is not a number.
int find_tetrahedron(const TetrahedralMesh& mesh, const Matrix3X& x, const Vector3& p);

// Barycentric coordinates of p in a tetrahedron of the current configuration.
Eigen::Vector4d barycentric(const TetrahedralMesh& mesh, const Matrix3X& x, int tetrahedron, const Vector3& p);

}  // namespace acus
