// SPDX-License-Identifier: GPL-3.0-or-later
// Points that are fixed in the tissue's material, and the linear shape functions that carry them.
#pragma once

#include <cassert>

#include "server/engine/models/geometry/tetrahedral_mesh.h"

namespace acus {

// A point of the tissue's material: a tetrahedron and the weights of its four nodes.
struct MaterialPoint {
  int tetrahedron = -1;
  Eigen::Vector4d weights = Eigen::Vector4d::Zero();
};

inline Vector3 material_position(const TetrahedralMesh& mesh, const Matrix3X& x, const MaterialPoint& p) {
  assert(p.tetrahedron >= 0 && p.tetrahedron < mesh.tetrahedron_count());
  const auto& nodes = mesh.tetrahedra[static_cast<std::size_t>(p.tetrahedron)];
  Vector3 position = Vector3::Zero();
  for (int k = 0; k < 4; ++k) position += p.weights[k] * x.col(nodes[k]);
  return position;
}

// A point between two material points, (1 - u) a + u b; b is not looked at where u is 0.
struct TissuePoint {
  MaterialPoint a, b;
  double u = 0;
};

inline Vector3 tissue_position(const TetrahedralMesh& mesh, const Matrix3X& x, const TissuePoint& p) {
  assert(p.u >= 0 && p.u <= 1);
  const Vector3 at_a = material_position(mesh, x, p.a);
  return p.u == 0 ? at_a : Vector3((1 - p.u) * at_a + p.u * material_position(mesh, x, p.b));
}

// The gradients of a tetrahedron's four shape functions in the configuration x (1/m), one column each.
Eigen::Matrix<double, 3, 4> shape_gradients(const TetrahedralMesh& mesh, const Matrix3X& x, int tetrahedron);

// The rotation of a tetrahedron's material by small displacements u = x - from (rad, world): half the curl of u,
// 1/2 sum over its nodes of grad N_k x u_k.
Vector3 material_rotation(const TetrahedralMesh& mesh, const Matrix3X& from, const Matrix3X& x, int tetrahedron);

}  // namespace acus
