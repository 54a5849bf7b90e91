// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/models/element/corotational_energy.h"

namespace acus {

namespace {

struct Decomposition {
  double f[3][3], q[4], r[3][3], s[3][3];

  Decomposition(const TetrahedronShape<double>& t, const double (&x)[4][3], const double (&warm)[4])
      : q{warm[0], warm[1], warm[2], warm[3]} {
    deformation_gradient(t, x, f);
    polar_rotation(f, q, r, s);
  }
};

using Row9 = Eigen::Matrix<double, 1, 9>;

// Axial vector a of Rᵀ dF as a 3 x 9 map of dF (row-major).
Eigen::Matrix<double, 3, 9> axial_map(const Matrix3& r) {
  Eigen::Matrix<double, 3, 9> map = Eigen::Matrix<double, 3, 9>::Zero();
  for (int k = 0; k < 3; ++k) {
    const int i = (k + 1) % 3, j = (k + 2) % 3;
    for (int row = 0; row < 3; ++row) {
      map(k, 3 * row + i) += r(row, j);  // (Rᵀ dF)(j, i)
      map(k, 3 * row + j) -= r(row, i);
    }
  }
  return map;
}

}  // namespace

Matrix3 corotational_strain(const TetrahedronShape<double>& t, const double (&x)[4][3], const double (&q)[4]) {
  const Decomposition d(t, x, q);
  Matrix3 strain;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) strain(i, j) = d.s[i][j] - (i == j ? 1 : 0);
  return strain;
}

double strain_energy(const TetrahedronShape<double>& t, const Matrix3& strain) {
  return t.volume * t.law.energy(strain);
}

double corotational_energy(const TetrahedronShape<double>& t, const double (&x)[4][3], const double (&q)[4]) {
  return strain_energy(t, corotational_strain(t, x, q));
}

VolumeStrain volume_strain(const TetrahedronShape<double>& t, const double (&x)[4][3], const double (&q)[4]) {
  const Decomposition d(t, x, q);
  VolumeStrain strain{d.s[0][0] + d.s[1][1] + d.s[2][2] - 3, {}};
  for (int i = 0; i < 3; ++i) {
    for (int a = 0; a < 3; ++a)
      strain.gradient(i, a + 1) =
          t.volume * (d.r[i][0] * t.gradient[a][0] + d.r[i][1] * t.gradient[a][1] + d.r[i][2] * t.gradient[a][2]);
    strain.gradient(i, 0) = -(strain.gradient(i, 1) + strain.gradient(i, 2) + strain.gradient(i, 3));
  }
  return strain;
}

Eigen::Matrix<double, 12, 12> corotational_tangent(const TetrahedronShape<double>& t, const double (&x)[4][3],
                                                   const double (&q)[4], bool exact, double p) {
  const Decomposition d(t, x, q);
  Matrix3 r, s;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) r(i, j) = d.r[i][j], s(i, j) = d.s[i][j];

  // d²psi = 2 mu dF:dF + lambda (R:dF)² + (lambda tr E + p - 2 mu) dR:dF, and dR:dF = aᵀ G⁻¹ a.
  Row9 trace_map;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) trace_map(3 * i + j) = r(i, j);
  const Eigen::Matrix<double, 3, 9> axial = axial_map(r);
  const Matrix3 g = exact ? Matrix3(s.trace() * Matrix3::Identity() - s) : Matrix3(2 * Matrix3::Identity());
  const auto [mu, lambda] = t.law;
  const double turning = (exact ? lambda * (s.trace() - 3) + p : 0) - 2 * mu;
  const Eigen::Matrix<double, 9, 9> c = 2 * mu * Eigen::Matrix<double, 9, 9>::Identity() +
                                        lambda * trace_map.transpose() * trace_map +
                                        turning * axial.transpose() * g.inverse() * axial;

  // dF(i, j) = sum over nodes of dx(node, i) gradN(node, j).
  Eigen::Matrix<double, 9, 12> b = Eigen::Matrix<double, 9, 12>::Zero();
  for (int node = 0; node < 4; ++node)
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) {
        b(3 * i + j, 3 * node + i) =
            node == 0 ? -(t.gradient[0][j] + t.gradient[1][j] + t.gradient[2][j]) : t.gradient[node - 1][j];
      }
  return t.volume * b.transpose() * c * b;
}

}  // namespace acus
