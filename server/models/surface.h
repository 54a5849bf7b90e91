// SPDX-License-Identifier: GPL-3.0-or-later
// Where a needle's tip meets the boundary of the tissue, in the current configuration x (3 x nodes, m, world).
#pragma once

#include <optional>

#include "server/models/tissue_motion.h"

namespace acus {

struct SurfacePoint {
  int triangle = -1;
  Eigen::Vector3d weights = Eigen::Vector3d::Zero();  // barycentric in the triangle
  Vector3 position = Vector3::Zero();                 // m
  Vector3 normal = Vector3::Zero();                   // unit, outward, smooth across shallow edges
  double distance = 0;                                // m, from the query point, along the normal
};

// Closest points on and crossings through the boundary triangles.
class Surface {
 public:
  explicit Surface(const TetrahedralMesh& mesh);

  // Box around the current boundary, grown by `margin`: whether p lies in it. Costs one pass over the boundary nodes;
  // the cheap first question while a needle is far away.
  bool near(const Matrix3X& x, const Vector3& p, double margin) const;

  // The first crossing from outside to inside of the segment from a to b, or nothing.
  std::optional<SurfacePoint> entry(const Matrix3X& x, const Vector3& a, const Vector3& b) const;

  // The closest point to p.
  SurfacePoint closest(const Matrix3X& x, const Vector3& p) const;

  MaterialPoint material(const SurfacePoint& point) const;

 private:
  SurfacePoint make_point(const Matrix3X& x, int triangle, const Eigen::Vector3d& weights, const Vector3& query) const;
  Vector3 corner_normal(const Matrix3X& x, int node, const Vector3& facing) const;

  const TetrahedralMesh& mesh_;
  std::vector<int> nodes_;                         // on the boundary
  std::vector<std::vector<int>> node_triangles_;   // per mesh node
};

// Follows the straight segment from `from` (inside `start.tetrahedron`) to `to` through the tetrahedra it crosses.
struct Trace {
  MaterialPoint end;           // the last point reached: `to`, or the point where the segment leaves the tissue
  bool left = false;           // the segment leaves through the boundary
};
Trace trace_segment(const TetrahedralMesh& mesh, const Matrix3X& x, int start, const Vector3& from, const Vector3& to);

// Barycentric coordinates of p in a tetrahedron of the current configuration.
Eigen::Vector4d barycentric(const TetrahedralMesh& mesh, const Matrix3X& x, int tetrahedron, const Vector3& p);

}  // namespace acus
