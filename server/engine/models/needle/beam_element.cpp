// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/models/needle/beam_element.h"

#include <cassert>
#include <cmath>

#include "server/engine/math/rotation.h"

namespace acus {

namespace {

// What energy, forces and tangents share.
struct Shape {
  Vector3 e;         // chord, unit
  double l;          // chord length (m)
  Vector3 t1, t2;    // tangents
  double psi;        // twist (rad)
  Vector3 mean;      // (t1 + t2)/(1 + t1·t2): d psi = mean·(theta2 - theta1)

  Shape(const BeamEnd& a, const BeamEnd& b) : t1(a.frame.col(0)), t2(b.frame.col(0)) {
    const Vector3 d = b.position - a.position;
    l = d.norm();
    e = d / l;
    const double sine = b.frame.col(1).dot(a.frame.col(2)) - b.frame.col(2).dot(a.frame.col(1));
    const double cosine = a.frame.col(1).dot(b.frame.col(1)) + a.frame.col(2).dot(b.frame.col(2));
    psi = std::atan2(sine, cosine);
    mean = (t1 + t2) / (1 + t1.dot(t2));
  }
};

// Adds the block matrix [B -B; -B B] at the rows and columns that start at i and j, e.g. both positions.
void add_difference(Matrix12& k, int i, int j, const Matrix3& block) {
  k.block<3, 3>(i, i) += block;
  k.block<3, 3>(j, j) += block;
  k.block<3, 3>(i, j) -= block;
  k.block<3, 3>(j, i) -= block.transpose();
}

void add_symmetric(Matrix12& k, int i, int j, const Matrix3& block) {
  k.block<3, 3>(i, j) += block;
  k.block<3, 3>(j, i) += block.transpose();
}

constexpr int kX1 = 0, kTheta1 = 3, kX2 = 6, kTheta2 = 9;

// Second derivative of t·g along exp(theta), t turning with theta.
Matrix3 turning_hessian(const Vector3& t, const Vector3& g) {
  return 0.5 * (t * g.transpose() + g * t.transpose()) - t.dot(g) * Matrix3::Identity();
}

}  // namespace

double beam_energy(const BeamStiffness& s, const BeamEnd& a, const BeamEnd& b) {
  assert(s.length > 0);
  const Shape q(a, b);
  const double stretch = q.l - s.length;
  // Written with slopes, not with the expanded products: no cancellation near the straight shape.
  const Vector3 slope1 = q.t1 - q.e, slope2 = q.t2 - q.e;
  const double bending = slope1.squaredNorm() + slope1.dot(slope2) + slope2.squaredNorm();
  return (0.5 * s.axial * stretch * stretch + 2 * s.bending * bending + 0.5 * s.torsion * q.psi * q.psi) / s.length;
}

Vector12 beam_forces(const BeamStiffness& s, const BeamEnd& a, const BeamEnd& b) {
  assert(s.length > 0);
  const Shape q(a, b);
  const double c = 2 * s.bending / s.length;
  const Vector3 sum = (q.t1 - q.e) + (q.t2 - q.e);
  const Vector3 across = sum - q.e.dot(sum) * q.e;  // of t1 + t2 to the chord
  const Vector3 f2 = s.axial * (q.l - s.length) / s.length * q.e - 3 * c / q.l * across;
  const Vector3 torque = s.torsion * q.psi / s.length * q.mean;
  Vector12 f;
  f << -f2, c * q.t1.cross(q.t2 - 3 * q.e) - torque, f2, c * q.t2.cross(q.t1 - 3 * q.e) + torque;
  return f;
}

Matrix12 beam_tangent(const BeamStiffness& s, const BeamEnd& a, const BeamEnd& b) {
  assert(s.length > 0);
  const Shape q(a, b);
  const Matrix3 identity = Matrix3::Identity();
  const Matrix3 across = identity - q.e * q.e.transpose();
  Matrix12 k = Matrix12::Zero();

  // Axial: N(l).
  const double force = s.axial * (q.l - s.length) / s.length;
  Matrix3 dd = s.axial / s.length * q.e * q.e.transpose() + force / q.l * across;

  // Bending: c (5 - 3 g·e + t1·t2), g = t1 + t2.
  const double c = 2 * s.bending / s.length;
  const Vector3 g = q.t1 + q.t2;
  const Vector3 g_across = across * g;
  dd += 3 * c / (q.l * q.l) * (g_across * q.e.transpose() + q.e * g_across.transpose() + g.dot(q.e) * across);
  add_difference(k, kX1, kX2, dd);

  const Matrix3 turn1 = -3 * c / q.l * skew(q.t1) * across;  // d²/dtheta1 dx2
  const Matrix3 turn2 = -3 * c / q.l * skew(q.t2) * across;
  add_symmetric(k, kTheta1, kX2, turn1);
  add_symmetric(k, kTheta1, kX1, -turn1);
  add_symmetric(k, kTheta2, kX2, turn2);
  add_symmetric(k, kTheta2, kX1, -turn2);
  k.block<3, 3>(kTheta1, kTheta1) += c * turning_hessian(q.t1, q.t2 - 3 * q.e);
  k.block<3, 3>(kTheta2, kTheta2) += c * turning_hessian(q.t2, q.t1 - 3 * q.e);
  add_symmetric(k, kTheta1, kTheta2, c * (q.t1.dot(q.t2) * identity - q.t2 * q.t1.transpose()));

  // Twist: GJ/L (grad psi gradᵀ psi + psi Hess psi).
  const double gj = s.torsion / s.length;
  const Vector3 normal = q.t2.cross(q.t1) / (1 + q.t1.dot(q.t2));
  const Matrix3 turning = 0.5 * (q.mean * normal.transpose() + normal * q.mean.transpose());
  add_difference(k, kTheta1, kTheta2, gj * (q.mean * q.mean.transpose() - q.psi * turning));
  add_symmetric(k, kTheta1, kTheta2, 0.5 * gj * q.psi * skew(q.mean));
  return k;
}

// The tangent of a straight, unstretched, untwisted beam along the same chord.
Matrix12 beam_material_tangent(const BeamStiffness& s, const BeamEnd& a, const BeamEnd& b) {
  assert(s.length > 0);
  const Shape q(a, b);
  const Matrix3 along = q.e * q.e.transpose(), across = Matrix3::Identity() - along;
  const double c = 2 * s.bending / s.length;
  Matrix12 k = Matrix12::Zero();
  add_difference(k, kX1, kX2, s.axial / s.length * along + 6 * c / (q.l * q.l) * across);
  const Matrix3 turn = -3 * c / q.l * skew(q.e);  // d²/dtheta dx2
  for (const int theta : {kTheta1, kTheta2}) {
    add_symmetric(k, theta, kX2, turn);
    add_symmetric(k, theta, kX1, -turn);
    k.block<3, 3>(theta, theta) += 2 * c * across;
  }
  add_symmetric(k, kTheta1, kTheta2, c * across);
  add_difference(k, kTheta1, kTheta2, s.torsion / s.length * along);
  return k;
}

}  // namespace acus
