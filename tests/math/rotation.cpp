// SPDX-License-Identifier: GPL-3.0-or-later
// Rotation vectors and the basis across a direction, at their difficult places: angle 0, angle pi, the poles.
#include "server/engine/math/rotation.h"

#include <doctest/doctest.h>

#include <vector>

#include "server/engine/math/random.h"

namespace acus {
namespace {

constexpr double kPi = std::numbers::pi;

TEST_CASE("skew(a) b is the cross product") {
  Random random(1);
  const Vector3 a = random.vector(), b = random.vector();
  CHECK((skew(a) * b - a.cross(b)).norm() < 1e-15);
}

TEST_CASE("the rotation of a rotation vector is Eigen's angle and axis") {
  Random random(2);
  for (const double angle : {0.0, 1e-300, 1e-12, 0.99e-4, 1.01e-4, 0.1, 1.0, kPi - 1e-9, kPi, 5.0, 40.0}) {
    const Vector3 axis = random.direction();
    const Quaternion q = rotation_exp(angle * axis);
    CHECK(std::abs(q.norm() - 1) < 1e-15);
    const Matrix3 expected = Eigen::AngleAxisd(angle, axis).toRotationMatrix();
    CHECK((q.toRotationMatrix() - expected).cwiseAbs().maxCoeff() < 1e-14);
  }
}

TEST_CASE("the logarithm undoes the exponential up to an angle of pi") {
  Random random(3);
  for (const double angle : {0.0, 1e-300, 1e-16, 1e-9, 1e-8, 1e-4, 0.5, 3.0, kPi - 1e-6, kPi - 1e-12}) {
    for (int repeat = 0; repeat < 20; ++repeat) {
      const Vector3 w = angle * random.direction();
      CHECK((rotation_log(rotation_exp(w)) - w).norm() <= 1e-15 * (1 + 10 * angle));
    }
  }
}

TEST_CASE("small angles keep their relative accuracy") {
  const Vector3 w = Vector3(1e-10, -2e-10, 3e-10);
  CHECK((rotation_log(rotation_exp(w)) - w).norm() < 1e-14 * w.norm());
}

TEST_CASE("half a turn has one of its two logarithms") {
  Random random(4);
  for (int repeat = 0; repeat < 20; ++repeat) {
    const Vector3 axis = random.direction();
    const Vector3 w = rotation_log(rotation_exp(kPi * axis));
    CHECK(w.norm() == doctest::Approx(kPi).epsilon(1e-14));
    CHECK(std::abs(w.dot(axis)) == doctest::Approx(kPi).epsilon(1e-14));
  }
}

TEST_CASE("q and -q have the same logarithm, at most pi long") {
  Random random(5);
  for (int repeat = 0; repeat < 100; ++repeat) {
    const Quaternion q = rotation_exp(random.uniform(0, 4 * kPi) * random.direction());
    const Quaternion opposite(-q.w(), -q.x(), -q.y(), -q.z());
    CHECK(rotation_log(q) == rotation_log(opposite));
    CHECK(rotation_log(q).norm() <= kPi * (1 + 1e-15));
  }
  CHECK(rotation_log(Quaternion(-1, 0, 0, 0)).isZero(0));
}

TEST_CASE("exp(a) exp(b) turns by b first") {
  const Vector3 quarter_z(0, 0, kPi / 2), quarter_x(kPi / 2, 0, 0);
  CHECK((rotation_exp(quarter_z) * rotation_exp(quarter_x) * Vector3::UnitY() - Vector3::UnitZ()).norm() < 1e-15);
}

// Everywhere on the sphere, and around the pole where the construction divides by nearly zero.
std::vector<Vector3> directions() {
  std::vector<Vector3> all;
  Random random(6);
  for (int i = 0; i < 2000; ++i) all.push_back(random.direction());
  for (const double z : {-1.0, 1.0}) {
    for (const double tilt : {0.0, 1e-300, 1e-17, 1e-12, 1e-8, 1e-4})
      all.push_back(Vector3(tilt * 0.6, -tilt * 0.8, z).normalized());
    all.push_back({0, z, 0.0});
    all.push_back({z, 0, -0.0});
  }
  return all;
}

TEST_CASE("the basis across a direction is orthonormal and right-handed everywhere") {
  for (const Vector3& n : directions()) {
    Matrix3 frame;
    Vector3 a, b;
    perpendicular_basis(n, a, b);
    frame << n, a, b;
    CAPTURE(n.transpose());
    CHECK((frame.transpose() * frame - Matrix3::Identity()).cwiseAbs().maxCoeff() < 1e-14);
    CHECK(frame.determinant() > 0.9);
  }
}

TEST_CASE("the basis turns continuously with the direction while n.z keeps its sign") {
  Random random(7);
  for (int repeat = 0; repeat < 2000; ++repeat) {
    const Vector3 n = random.direction();
    const Vector3 moved = rotation_exp(random.vector(1e-6)) * n;
    if (std::signbit(n.z()) != std::signbit(moved.z())) continue;
    Vector3 a, b, moved_a, moved_b;
    perpendicular_basis(n, a, b);
    perpendicular_basis(moved, moved_a, moved_b);
    CHECK((moved_a - a).norm() < 1e-5);
    CHECK((moved_b - b).norm() < 1e-5);
  }
}

}  // namespace
}  // namespace acus
