// SPDX-License-Identifier: GPL-3.0-or-later
// Energy, volume strain and second derivatives of one corotational tetrahedron (corotational_tetrahedron.h).
#pragma once

#include "server/engine/math/types.h"
#include "server/engine/models/element/corotational_tetrahedron.h"

namespace acus {

// The energy Psi (J) at node positions x, with the rotation found from the warm start q.
double corotational_energy(const TetrahedronShape<double>& t, const double (&x)[4][3], const double (&q)[4]);

// E itself, 3 x 3, with the rotation found from the warm start q, and the energy of a strain (J).
Matrix3 corotational_strain(const TetrahedronShape<double>& t, const double (&x)[4][3], const double (&q)[4]);
double strain_energy(const TetrahedronShape<double>& t, const Matrix3& strain);

// theta = tr(E) with the rotation found from the warm start q, and V dtheta/dx = V R grad N (m²), one column per node.
struct VolumeStrain {
  double value;
  Eigen::Matrix<double, 3, 4> gradient;
};
VolumeStrain volume_strain(const TetrahedronShape<double>& t, const double (&x)[4][3], const double (&q)[4]);

// Second derivative of Psi + V p theta for a pressure p that stays (Pa), in N/m; unknowns in the order node * 3 + axis.
// `exact` gives the Hessian, which can be indefinite under compression; otherwise R K Rᵀ, the rest stiffness turned
// with the element, always semidefinite, whatever p is.
Eigen::Matrix<double, 12, 12> corotational_tangent(const TetrahedronShape<double>& t, const double (&x)[4][3],
                                                   const double (&q)[4], bool exact, double p = 0);

}  // namespace acus
