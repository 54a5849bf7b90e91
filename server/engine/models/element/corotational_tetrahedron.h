// SPDX-License-Identifier: GPL-3.0-or-later
// Corotational linear tetrahedron: large rotations, small strains, with the law of hooke.h.
//
// With F = dx/dX (constant in the element), F = R S its polar decomposition and E = S - I the strain, the energy is
//
//   Psi = V (mu E:E + lambda/2 tr(E)²),      P = dPsi/dF / V = R (2 mu E + lambda tr(E) I)
//
// which is the gradient of Psi with R moving along, since (F - R):dR = 0. Nodal forces dPsi/dx are V P grad N_a: the
// force that must be applied from outside; they sum to zero and have no net moment.
// [Müller, Gross 2004, "Interactive virtual materials"; McAdams et al. 2011 for the energy and its derivatives]
//
// R is found by Newton's method on tr(Rᵀ F) from the last tick's R: with A = Rᵀ F, S = sym A and
// a = (A32 - A23, A13 - A31, A21 - A12), the step is omega = (tr(S) I - S)⁻¹ a. It converges quadratically; where the
// matrix is not positive (an element close to inversion) a bounded first-order step is taken instead
// [Müller et al. 2016, "A robust method to extract the rotational part of deformations"].
//
// Everything is templated over the number type: Real = double is one element, Lanes eight of them at once in the vector
// registers, with constants from memory (Stored = Octet).
#pragma once

#include "server/engine/math/lanes.h"
#include "server/engine/models/element/hooke.h"

namespace acus {

// Constant per element.
template <class Stored>
struct TetrahedronShape {
  Stored gradient[3][3];  // rows: grad N_1, grad N_2, grad N_3 (1/m); grad N_0 = minus their sum
  Stored volume;          // m³
  Hooke<Stored> law;
};

// 1/sqrt(n) for n near 1, where a few terms of its series are exact to rounding and sooner there.
template <class Real>
inline Real reciprocal_root(const Real& n) {
  constexpr double kNear = 1e-4;
  const Real e = n - 1.0;
  if (all(e * e < kNear * kNear)) return 1.0 - e * (0.5 - e * (0.375 - e * (0.3125 - e * 0.2734375)));
  return 1.0 / square_root(n);
}

// Rotation matrix of the unit quaternion (w, x, y, z).
template <class Real>
inline void quaternion_matrix(const Real (&q)[4], Real (&r)[3][3]) {
  const Real xx = q[1] * q[1], yy = q[2] * q[2], zz = q[3] * q[3];
  const Real xy = q[1] * q[2], xz = q[1] * q[3], yz = q[2] * q[3];
  const Real wx = q[0] * q[1], wy = q[0] * q[2], wz = q[0] * q[3];
  r[0][0] = 1.0 - 2.0 * (yy + zz), r[0][1] = 2.0 * (xy - wz), r[0][2] = 2.0 * (xz + wy);
  r[1][0] = 2.0 * (xy + wz), r[1][1] = 1.0 - 2.0 * (xx + zz), r[1][2] = 2.0 * (yz - wx);
  r[2][0] = 2.0 * (xz - wy), r[2][1] = 2.0 * (yz + wx), r[2][2] = 1.0 - 2.0 * (xx + yy);
}

// c = aᵀ b.
template <class Real>
inline void transposed_product(const Real (&a)[3][3], const Real (&b)[3][3], Real (&c)[3][3]) {
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) c[i][j] = a[0][i] * b[0][j] + a[1][i] * b[1][j] + a[2][i] * b[2][j];
}

// Turns q (unit quaternion, kept unit) into the rotation of f. On return r is its matrix and s = sym(Rᵀ F).
template <class Real>
inline void polar_rotation(const Real (&f)[3][3], Real (&q)[4], Real (&r)[3][3], Real (&s)[3][3]) {
  constexpr int kMaxIterations = 20;
  constexpr double kStop = 1e-12;  // |omega|²: the step leaves an error of its square
  Real size2 = 0.0 * f[0][0] + 1e-300;  // |F|², never zero
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) size2 = size2 + f[i][j] * f[i][j];
  const Real size = square_root(size2);
  for (int iteration = 0;; ++iteration) {
    Real a[3][3];
    quaternion_matrix(q, r);
    transposed_product(r, f, a);
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) s[i][j] = 0.5 * (a[i][j] + a[j][i]);
    if (iteration == kMaxIterations) return;
    const Real a0 = a[2][1] - a[1][2], a1 = a[0][2] - a[2][0], a2 = a[1][0] - a[0][1];

    // G = tr(S) I - S and its adjugate.
    const Real g00 = s[1][1] + s[2][2], g11 = s[0][0] + s[2][2], g22 = s[0][0] + s[1][1];
    const Real g01 = -s[0][1], g02 = -s[0][2], g12 = -s[1][2];
    const Real c00 = g11 * g22 - g12 * g12, c01 = g02 * g12 - g01 * g22, c02 = g01 * g12 - g02 * g11;
    const Real c11 = g00 * g22 - g02 * g02, c12 = g01 * g02 - g00 * g12, c22 = g00 * g11 - g01 * g01;
    const Real determinant = g00 * c00 + g01 * c01 + g02 * c02;

    const auto regular = (g00 > 1e-3 * size) & (c22 > 1e-4 * size2) & (determinant > 1e-5 * size2 * size);
    const Real newton = 1.0 / select(regular, determinant, size2 * size);
    Real w0 = (c00 * a0 + c01 * a1 + c02 * a2) * newton;
    Real w1 = (c01 * a0 + c11 * a1 + c12 * a2) * newton;
    Real w2 = (c02 * a0 + c12 * a1 + c22 * a2) * newton;
    if (!all(regular)) {
      const Real trace = s[0][0] + s[1][1] + s[2][2];
      const Real first_order = 1.0 / (select(trace > 0.0, trace, -trace) + 0.3 * size);
      w0 = select(regular, w0, a0 * first_order);
      w1 = select(regular, w1, a1 * first_order);
      w2 = select(regular, w2, a2 * first_order);
    }

    // q <- q (1, omega/2), normalised: a rotation by 2 atan(|omega|/2).
    const Real p0 = 0.5 * w0, p1 = 0.5 * w1, p2 = 0.5 * w2;
    const Real n0 = q[0] - q[1] * p0 - q[2] * p1 - q[3] * p2;
    const Real n1 = q[1] + q[0] * p0 + q[2] * p2 - q[3] * p1;
    const Real n2 = q[2] + q[0] * p1 + q[3] * p0 - q[1] * p2;
    const Real n3 = q[3] + q[0] * p2 + q[1] * p1 - q[2] * p0;
    const Real unit = reciprocal_root(n0 * n0 + n1 * n1 + n2 * n2 + n3 * n3);
    q[0] = n0 * unit, q[1] = n1 * unit, q[2] = n2 * unit, q[3] = n3 * unit;

    const Real step2 = w0 * w0 + w1 * w1 + w2 * w2;
    if (all(step2 <= kStop)) iteration = kMaxIterations - 1;  // one last evaluation of r and s
  }
}

// Deformation gradient from the node positions x[node][axis].
template <class Real, class Stored>
inline void deformation_gradient(const TetrahedronShape<Stored>& t, const Real (&x)[4][3], Real (&f)[3][3]) {
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      f[i][j] = (x[1][i] - x[0][i]) * t.gradient[0][j] + (x[2][i] - x[0][i]) * t.gradient[1][j] +
                (x[3][i] - x[0][i]) * t.gradient[2][j];
    }
}

// force[node][axis] = V R S grad N, for a rotation r and a strain e + shift I, both 3 x 3.
template <class Real, class Stored>
inline void nodal_forces(const TetrahedronShape<Stored>& t, const Real (&r)[3][3], const Real (&e)[3][3], double shift,
                         Real (&force)[4][3]) {
  Real stress[3][3];
  t.law.stress(e, shift, stress);
  for (int i = 0; i < 3; ++i) {
    const Real p0 = t.volume * (r[i][0] * stress[0][0] + r[i][1] * stress[1][0] + r[i][2] * stress[2][0]);
    const Real p1 = t.volume * (r[i][0] * stress[0][1] + r[i][1] * stress[1][1] + r[i][2] * stress[2][1]);
    const Real p2 = t.volume * (r[i][0] * stress[0][2] + r[i][1] * stress[1][2] + r[i][2] * stress[2][2]);
    for (int a = 0; a < 3; ++a)
      force[a + 1][i] = p0 * t.gradient[a][0] + p1 * t.gradient[a][1] + p2 * t.gradient[a][2];
    force[0][i] = -(force[1][i] + force[2][i] + force[3][i]);
  }
}

// force[node][axis] = dPsi/dx (N); q is the element's rotation, updated. Returns theta = tr(E).
template <class Real, class Stored>
inline Real corotational_forces(const TetrahedronShape<Stored>& t, const Real (&x)[4][3], Real (&q)[4],
                                Real (&force)[4][3]) {
  Real f[3][3], r[3][3], s[3][3];
  deformation_gradient(t, x, f);
  polar_rotation(f, q, r, s);
  nodal_forces(t, r, s, -1, force);
  return s[0][0] + s[1][1] + s[2][2] - 3.0;
}

// Where a strain stands among the six that are kept of a symmetric one.
inline constexpr int kStrainPlace[3][3] = {{0, 3, 4}, {3, 1, 5}, {4, 5, 2}};
inline constexpr int kStrainEntry[6][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {0, 2}, {1, 2}};

// force[node][axis] of the strain g E - kept (tissue_memory.h), `kept` as six numbers; q is updated. Returns theta.
template <class Real, class Stored>
inline Real remembering_forces(const TetrahedronShape<Stored>& t, const Real (&x)[4][3], const Real& g,
                               const Real (&kept)[6], Real (&q)[4], Real (&force)[4][3]) {
  Real f[3][3], r[3][3], s[3][3], e[3][3];
  deformation_gradient(t, x, f);
  polar_rotation(f, q, r, s);
  const Real theta = s[0][0] + s[1][1] + s[2][2] - 3.0;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) e[i][j] = g * (s[i][j] - (i == j ? 1.0 : 0.0)) - kept[kStrainPlace[i][j]];
  nodal_forces(t, r, e, 0, force);
  return theta;
}

// E, and the rotation's matrix r, for a rotation q that stays.
template <class Real, class Stored>
inline void strain_of(const TetrahedronShape<Stored>& t, const Real (&x)[4][3], const Real (&q)[4], Real (&r)[3][3],
                      Real (&strain)[6]) {
  Real f[3][3], a[3][3];
  deformation_gradient(t, x, f);
  quaternion_matrix(q, r);
  transposed_product(r, f, a);
  for (int k = 0; k < 6; ++k) {
    const int i = kStrainEntry[k][0], j = kStrainEntry[k][1];
    strain[k] = 0.5 * (a[i][j] + a[j][i]) - (i == j ? 1.0 : 0.0);
  }
}

// force[node][axis] of a strain of six numbers, for a rotation r.
template <class Real, class Stored>
inline void strain_forces(const TetrahedronShape<Stored>& t, const Real (&r)[3][3], const Real (&strain)[6],
                          Real (&force)[4][3]) {
  Real e[3][3];
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) e[i][j] = strain[kStrainPlace[i][j]];
  nodal_forces(t, r, e, 0, force);
}

// force = V p dtheta/dx = V p R grad N: what a pressure p (Pa, tension positive) adds, for a rotation q that stays.
template <class Real, class Stored>
inline void pressure_forces(const TetrahedronShape<Stored>& t, const Real& p, const Real (&q)[4], Real (&force)[4][3]) {
  Real r[3][3];
  quaternion_matrix(q, r);
  const Real scale = t.volume * p;
  for (int i = 0; i < 3; ++i) {
    for (int a = 0; a < 3; ++a)
      force[a + 1][i] =
          scale * (r[i][0] * t.gradient[a][0] + r[i][1] * t.gradient[a][1] + r[i][2] * t.gradient[a][2]);
    force[0][i] = -(force[1][i] + force[2][i] + force[3][i]);
  }
}

// force = R K0 Rᵀ u for small displacements u[node][axis] (m) and a rotation q that stays. Returns dtheta/dx u.
template <class Real, class Stored>
inline Real turned_stiffness_forces(const TetrahedronShape<Stored>& t, const Real (&u)[4][3], const Real (&q)[4],
                                    Real (&force)[4][3]) {
  Real f[3][3], r[3][3], a[3][3], e[3][3];
  deformation_gradient(t, u, f);
  quaternion_matrix(q, r);
  transposed_product(r, f, a);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) e[i][j] = 0.5 * (a[i][j] + a[j][i]);
  nodal_forces(t, r, e, 0, force);
  return e[0][0] + e[1][1] + e[2][2];
}

}  // namespace acus
