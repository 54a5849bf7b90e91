// SPDX-License-Identifier: GPL-3.0-or-later
// Rotation vectors (axis times angle, rad, world frame) and what goes with them. exp(a) exp(b) turns by b first.
#pragma once

#include <cassert>
#include <cmath>

#include "server/engine/math/types.h"

namespace acus {

// Rotations whose quaternions have larger real parts differ by less than a right angle: the quaternions have one sign.
inline constexpr double kOneSign = 0.70711;

// [a]x with [a]x b = a x b.
inline Matrix3 skew(const Vector3& a) {
  Matrix3 m;
  m << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
  return m;
}

// The rotation of angle |w| about w.
inline Quaternion rotation_exp(const Vector3& w) {
  const double angle = w.norm();
  // sin(angle/2)/angle, by its series where the quotient loses digits.
  const double s = angle < 1e-4 ? 0.5 - angle * angle / 48 : std::sin(angle / 2) / angle;
  return {std::cos(angle / 2), s * w.x(), s * w.y(), s * w.z()};
}

// The rotation vector of q with angle in [0, pi]; q and -q give the same.
inline Vector3 rotation_log(const Quaternion& q) {
  assert(!(std::abs(q.squaredNorm() - 1) > 1e-6));
  const double sign = q.w() < 0 ? -1 : 1;
  const double sine = q.vec().norm();
  const double factor = sine < 1e-8 ? 2 : 2 * std::atan2(sine, sign * q.w()) / sine;
  return sign * factor * q.vec();
}

// The shortest rotation that turns the direction of `from` to that of `to`, both not zero; where they are opposite, about
// some axis across them. Not inline: it takes seconds to compile.
Quaternion rotation_between(const Vector3& from, const Vector3& to);

// Two unit vectors that make a right-handed frame (n, a, b) with the unit vector n; they change continuously with n
// but for a jump where n.z changes its sign (Duff et al. 2017, "Building an orthonormal basis, revisited").
inline void perpendicular_basis(const Vector3& n, Vector3& a, Vector3& b) {
  assert(!(std::abs(n.squaredNorm() - 1) > 1e-6));
  const double sign = std::copysign(1.0, n.z());
  const double c = -1 / (sign + n.z());
  const double d = n.x() * n.y() * c;
  a = {1 + sign * n.x() * n.x() * c, sign * d, -sign * n.x()};
  b = {d, sign + n.y() * n.y() * c, -n.y()};
}

}  // namespace acus
