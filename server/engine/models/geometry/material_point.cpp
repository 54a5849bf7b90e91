// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/models/geometry/material_point.h"

#include <cassert>
#include <cmath>

namespace acus {

Eigen::Matrix<double, 3, 4> shape_gradients(const TetrahedralMesh& mesh, const Matrix3X& x, int tetrahedron) {
  assert(tetrahedron >= 0 && tetrahedron < mesh.tetrahedron_count());
  const auto& nodes = mesh.tetrahedra[tetrahedron];
  const Vector3 a = x.col(nodes[1]) - x.col(nodes[0]), b = x.col(nodes[2]) - x.col(nodes[0]),
                c = x.col(nodes[3]) - x.col(nodes[0]);
  const double six_volume = a.dot(b.cross(c));
  Eigen::Matrix<double, 3, 4> gradients = Eigen::Matrix<double, 3, 4>::Zero();
  if (!(std::abs(six_volume) > 1e-12 * a.norm() * b.norm() * c.norm())) return gradients;  // flat: nothing to turn
  gradients.col(1) = b.cross(c) / six_volume;
  gradients.col(2) = c.cross(a) / six_volume;
  gradients.col(3) = a.cross(b) / six_volume;
  gradients.col(0) = -(gradients.col(1) + gradients.col(2) + gradients.col(3));
  return gradients;
}

Vector3 material_rotation(const TetrahedralMesh& mesh, const Matrix3X& from, const Matrix3X& x, int tetrahedron) {
  assert(from.cols() == x.cols());
  const auto gradients = shape_gradients(mesh, x, tetrahedron);
  Vector3 sum = Vector3::Zero();
  for (int k = 0; k < 4; ++k) {
    const int node = mesh.tetrahedra[tetrahedron][k];
    sum += gradients.col(k).cross(Vector3(x.col(node) - from.col(node)));
  }
  return sum / 2;
}

}  // namespace acus
