// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/haptics/vectors.h"

#include <doctest/doctest.h>

#include <numbers>

using namespace acus::haptics;

TEST_CASE("rotations: a quarter turn about z takes x to y, and its vector is its angle") {
  const Quaternion q = rotation({{0, 0, std::numbers::pi / 2}});
  const Vector3 turned = q * Vector3{{1, 0, 0}};
  CHECK(norm(turned - Vector3{{0, 1, 0}}) < 1e-15);
  CHECK(rotation_vector(q)[2] == doctest::Approx(std::numbers::pi / 2));
  CHECK(norm(rotation_vector({-q.w, -q.x, -q.y, -q.z}) - rotation_vector(q)) < 1e-15);  // the same rotation
}

TEST_CASE("a displacement leads from one pose to the other") {
  const Pose from{{{1, 2, 3}}, rotation({{0.3, -0.2, 0.9}})};
  const Pose to{{{1.5, 1, 3}}, rotation({{-0.4, 0.1, 0.2}})};
  const Pose back = displaced(from, displacement(from, to));
  CHECK(norm(back.position - to.position) < 1e-14);
  CHECK(norm(rotation_vector(back.orientation * to.orientation.conjugate())) < 1e-14);
}

TEST_CASE("equations are solved, and a matrix that is not positive definite is refused") {
  Matrix<3> a{{4, 1, 0, 1, 3, 1, 0, 1, 2}};
  Vector3 x{{7, 7, 7}};
  REQUIRE(solve(a, a * Vector3{{1, -2, 3}}, x));
  CHECK(norm(x - Vector3{{1, -2, 3}}) < 1e-14);
  a(2, 2) = -2;
  CHECK_FALSE(solve(a, {{1, 1, 1}}, x));
  CHECK(norm(x - Vector3{{1, -2, 3}}) < 1e-14);  // untouched
}

TEST_CASE("eigenvalues and eigenvectors make the matrix again") {
  Matrix6 a;
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j <= i; ++j) a(i, j) = a(j, i) = std::sin(1.0 + 3 * i + 7 * j) * (i == j ? 1e3 : 10);
  const Spectrum s = spectrum(a);
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j) {
      double sum = 0;
      for (int k = 0; k < 6; ++k) sum += s.vectors(i, k) * s.values[k] * s.vectors(j, k);
      CHECK(sum == doctest::Approx(a(i, j)).epsilon(1e-11).scale(1e3));
    }
}
