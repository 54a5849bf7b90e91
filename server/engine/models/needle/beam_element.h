// SPDX-License-Identifier: GPL-3.0-or-later
// Corotational Euler-Bernoulli beam between two nodes, circular (solid or hollow) section, large displacements and
// rotations, small strains.
//
// The chord e = d/l, d = x2 - x1, l = |d|, is the element's rotating frame; t1, t2 are the nodes' tangents (unit). The
// slopes seen from the chord are t1 - e and t2 - e, and linear beam theory holds in that frame. With the twist psi of
// node 2 against node 1 about the mean tangent, the elastic energy is
//
//   Psi = EA/(2L) (l - L)² + 2EI/L (|t1 - e|² + (t1 - e)·(t2 - e) + |t2 - e|²) + GJ/(2L) psi²
//       = EA/(2L) (l - L)² + 2EI/L (5 - 3 t1·e - 3 t2·e + t1·t2)               + GJ/(2L) psi²
//
// The slope |t - e| = 2 sin(angle/2) departs from the angle by angle²/24, 4e-5 at 0.03 rad. A circular section bends
// alike in all planes, so no section axes are needed; the twist is exact for any bend (swing-twist decomposition).
// Frame-indifferent; forces and moments balance exactly.
//
// Generalised coordinates (x1, theta1, x2, theta2), theta a world-frame rotation vector on top of the current
// orientation. forces = dPsi/dq, i.e. the force that must be applied from outside. Hessian exact and symmetric (the
// second derivative along exp(theta)).
#pragma once

#include "server/engine/math/types.h"

namespace acus {

using Vector12 = Eigen::Matrix<double, 12, 1>;
using Matrix12 = Eigen::Matrix<double, 12, 12>;

struct BeamStiffness {
  double length;       // L (m), at rest
  double axial;        // EA (N)
  double bending;      // EI (N m²)
  double torsion;      // GJ (N m²)
};

struct BeamEnd {
  Vector3 position;    // m, world
  Matrix3 frame;       // columns: tangent and two directions across, world
};

double beam_energy(const BeamStiffness& s, const BeamEnd& a, const BeamEnd& b);

Vector12 beam_forces(const BeamStiffness& s, const BeamEnd& a, const BeamEnd& b);

// The exact Hessian; indefinite for a strongly compressed element.
Matrix12 beam_tangent(const BeamStiffness& s, const BeamEnd& a, const BeamEnd& b);

// The part of the Hessian that is the elastic stiffness of the chord frame: positive semidefinite, zero for every rigid
// motion, equal to the Hessian where there is no load. Serves Rayleigh damping and as the tangent of last resort.
Matrix12 beam_material_tangent(const BeamStiffness& s, const BeamEnd& a, const BeamEnd& b);

}  // namespace acus
