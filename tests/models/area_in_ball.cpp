// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/models/geometry/area_in_ball.h"

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

#include "server/engine/math/random.h"

namespace acus {
namespace {

double area(const Vector3& a, const Vector3& b, const Vector3& c) { return (b - a).cross(c - a).norm() / 2; }

// By the middles of small triangles.
double counted(const Vector3& a, const Vector3& b, const Vector3& c, const Vector3& centre, double radius) {
  constexpr int kParts = 400;
  int inside = 0;
  const auto count = [&](double i, double j) {
    const Vector3 p = a + i / kParts * (b - a) + j / kParts * (c - a);
    inside += (p - centre).norm() < radius;
  };
  for (int i = 0; i < kParts; ++i)
    for (int j = 0; i + j < kParts; ++j) {
      count(i + 1 / 3.0, j + 1 / 3.0);
      if (i + j + 1 < kParts) count(i + 2 / 3.0, j + 2 / 3.0);
    }
  return inside * area(a, b, c) / (kParts * kParts);
}

const Vector3 kA(0, 0, 0), kB(1, 0, 0), kC(0.2, 0.9, 0);

}  // namespace

TEST_CASE("a ball within the edges cuts out its circle, one around the triangle all of it") {
  const Vector3 middle = (kA + kB + kC) / 3;
  CHECK(area_in_ball(kA, kB, kC, middle, 0.1) == doctest::Approx(std::numbers::pi * 0.01).epsilon(1e-12));
  CHECK(area_in_ball(kA, kB, kC, middle + Vector3(0, 0, 0.06), 0.1) ==
        doctest::Approx(std::numbers::pi * (0.01 - 0.0036)).epsilon(1e-12));
  CHECK(area_in_ball(kA, kB, kC, middle, 2) == doctest::Approx(area(kA, kB, kC)).epsilon(1e-12));
  CHECK(area_in_ball(kA, kC, kB, middle, 2) == doctest::Approx(area(kA, kB, kC)).epsilon(1e-12));
}

TEST_CASE("at a corner it is the corner's sector, wherever the triangle lies") {
  Random random(3);
  for (int i = 0; i < 100; ++i) {
    const Vector3 a = random.vector(1), b = random.vector(1), c = random.vector(1);
    const double angle = std::atan2((b - a).cross(c - a).norm(), (b - a).dot(c - a)), radius = 1e-3;
    CHECK(area_in_ball(a, b, c, a, radius) == doctest::Approx(angle / 2 * radius * radius).epsilon(1e-6));
    CHECK(area_in_ball(b, c, a, a, radius) == doctest::Approx(angle / 2 * radius * radius).epsilon(1e-6));
  }
}

TEST_CASE("on an edge it is half the circle, beside and above the ball nothing") {
  CHECK(area_in_ball(kA, kB, kC, {0.5, 0, 0}, 0.1) == doctest::Approx(std::numbers::pi * 0.005).epsilon(1e-12));
  CHECK(area_in_ball(kA, kB, kC, {0.5, -0.1, 0}, 0.1) < 1e-12);
  CHECK(area_in_ball(kA, kB, kC, {0.4, 0.3, 0.1}, 0.1) == 0);
  CHECK(area_in_ball(kA, kB, kB, {0.5, 0, 0}, 0.1) == 0);
}

TEST_CASE("anywhere it is what a fine division counts") {
  Random random(7);
  for (int i = 0; i < 20; ++i) {
    const Vector3 a = random.vector(1), b = random.vector(1), c = random.vector(1), centre = random.vector(0.7);
    const double radius = random.uniform(0.2, 1.5);
    CHECK(std::abs(area_in_ball(a, b, c, centre, radius) - counted(a, b, c, centre, radius)) < 3e-3 * area(a, b, c));
  }
}

}  // namespace acus
