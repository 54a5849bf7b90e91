// SPDX-License-Identifier: GPL-3.0-or-later
// The law of tissue in an element: what a strain costs and what it is answered with. With E the strain of a
// corotational element (corotational_tetrahedron.h), per volume,
//
//   psi(E) = mu E:E + lambda/2 tr(E)²,      S = dpsi/dE = 2 mu E + lambda tr(E) I
//
// An element's force is R S, which is the gradient of its energy only where S has the axes of E, as of every isotropic
// law; its second derivative (corotational_energy.h) is that of this one. What the mesh does not resolve: moduli.h.
#pragma once

namespace acus {

// Of one element, or of eight at once (Stored = Octet).
template <class Stored>
struct Hooke {
  Stored mu, lambda;  // Lamé constants (Pa)

  // S of the strain e + shift I, all 3 x 3.
  template <class Real>
  void stress(const Real (&e)[3][3], double shift, Real (&s)[3][3]) const {
    const Real shear = 2.0 * Real(mu);
    const Real pressure = lambda * (e[0][0] + e[1][1] + e[2][2] + 3.0 * shift) + shear * shift;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) s[i][j] = shear * e[i][j];
    for (int i = 0; i < 3; ++i) s[i][i] = s[i][i] + pressure;
  }

  // psi (J/m³) of a strain, 3 x 3.
  template <class Matrix>
  double energy(const Matrix& strain) const {
    const double trace = strain.trace();
    return mu * strain.squaredNorm() + 0.5 * lambda * trace * trace;
  }

  // The part of lambda above `most` (Pa), which the law has no more: nodes bear it (nodal_pressure.h).
  double take_volumetric(double most) {
    const double left = lambda < most ? lambda : most, taken = lambda - left;
    lambda = left;
    return taken;
  }
};

}  // namespace acus
