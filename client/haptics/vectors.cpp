// SPDX-License-Identifier: MIT
#include "client/haptics/vectors.h"

#include <algorithm>

namespace acus::haptics {

namespace {

constexpr int kSweeps = 12;  // Jacobi converges quadratically; 6 x 6 takes four to six

// Turns rows and columns p and q so that a(p, q) becomes zero (Golub and Van Loan, Matrix Computations, 8.5).
void rotate(Matrix6& a, Matrix6& vectors, int p, int q) {
  if (a(p, q) == 0) return;
  const double theta = (a(q, q) - a(p, p)) / (2 * a(p, q));
  const double t = std::copysign(1.0, theta) / (std::abs(theta) + std::sqrt(1 + theta * theta));
  const double c = 1 / std::sqrt(1 + t * t), s = t * c;
  for (int k = 0; k < 6; ++k) {
    const double kp = a(k, p), kq = a(k, q);
    a(k, p) = c * kp - s * kq;
    a(k, q) = s * kp + c * kq;
  }
  for (int k = 0; k < 6; ++k) {
    const double pk = a(p, k), qk = a(q, k);
    a(p, k) = c * pk - s * qk;
    a(q, k) = s * pk + c * qk;
    const double kp = vectors(k, p), kq = vectors(k, q);
    vectors(k, p) = c * kp - s * kq;
    vectors(k, q) = s * kp + c * kq;
  }
}

}  // namespace

Quaternion normalized(const Quaternion& q) {
  const double length = std::sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
  if (!(length > 0)) return {};
  return {q.w / length, q.x / length, q.y / length, q.z / length};
}

Vector3 rotation_vector(const Quaternion& q) {
  const double sign = q.w < 0 ? -1 : 1;
  const Vector3 v = sign * q.vector();
  const double sine = norm(v);
  if (sine < 1e-12) return 2 * v;
  return 2 * std::atan2(sine, sign * q.w) / sine * v;
}

Quaternion rotation(const Vector3& rotation_vector) {
  const double angle = norm(rotation_vector);
  const double share = angle < 1e-12 ? 0.5 : std::sin(angle / 2) / angle;
  const Vector3 v = share * rotation_vector;
  return normalized({std::cos(angle / 2), v[0], v[1], v[2]});
}

Vector6 displacement(const Pose& from, const Pose& to) {
  return joined(to.position - from.position, rotation_vector(to.orientation * from.orientation.conjugate()));
}

Pose displaced(const Pose& from, const Vector6& by) {
  const Wrench parts = wrench_of(by);  // upper and lower half
  return {from.position + parts.force, normalized(rotation(parts.torque) * from.orientation)};
}

Vector6 joined(const Vector3& upper, const Vector3& lower) {
  return {{upper[0], upper[1], upper[2], lower[0], lower[1], lower[2]}};
}

Wrench wrench_of(const Vector6& joined) {
  return {{{joined[0], joined[1], joined[2]}}, {{joined[3], joined[4], joined[5]}}};
}

Vector6 turned(const Quaternion& q, const Vector6& v) {
  const Wrench halves = wrench_of(v);
  return joined(q * halves.force, q * halves.torque);
}

Spectrum spectrum(Matrix6 a) {
  Spectrum result;
  for (int i = 0; i < 6; ++i) result.vectors(i, i) = 1;
  for (int sweep = 0; sweep < kSweeps; ++sweep)
    for (int p = 0; p < 6; ++p)
      for (int q = p + 1; q < 6; ++q) rotate(a, result.vectors, p, q);
  for (int i = 0; i < 6; ++i) result.values[i] = a(i, i);
  return result;
}

}  // namespace acus::haptics
