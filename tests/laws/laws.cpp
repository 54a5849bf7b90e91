// SPDX-License-Identifier: GPL-3.0-or-later
// Each law at every branch of its graph: the force lies on the graph and on the line at once.
#include "server/engine/laws/laws.h"

#include <doctest/doctest.h>

#include <limits>

#include "server/engine/math/random.h"

namespace acus {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();
constexpr double kCompliance = 0.01;  // m/N

double delta_at(double force, double delta_bar) { return kCompliance * force + delta_bar; }

TEST_CASE("bilateral: no displacement is left") {
  for (const double delta_bar : {-0.3, 0.0, 0.2}) {
    const double force = law_force({LawKind::bilateral}, kCompliance, delta_bar);
    CHECK(std::abs(delta_at(force, delta_bar)) < 1e-16);
  }
}

TEST_CASE("a soft bilateral row gives way by its compliance") {
  const Law law{.kind = LawKind::bilateral, .compliance = 3 * kCompliance};
  const double force = law_force(law, kCompliance, 0.2);
  CHECK(force == doctest::Approx(-0.2 / (4 * kCompliance)));
  CHECK(delta_at(force, 0.2) == doctest::Approx(-3 * kCompliance * force));
}

TEST_CASE("unilateral: open, closed, and at its cap") {
  const Law law{LawKind::unilateral, 5};
  CHECK(law_force(law, kCompliance, 0.02) == 0);
  CHECK(law_force(law, kCompliance, 0) == 0);
  CHECK(law_force(law, kCompliance, -0.02) == doctest::Approx(2));
  CHECK(law_force(law, kCompliance, -0.05) == doctest::Approx(5));
  CHECK(law_force(law, kCompliance, -1) == 5);
  CHECK(law_force({LawKind::unilateral, kInfinite}, kCompliance, -1) == doctest::Approx(100));
  CHECK(law_force({LawKind::unilateral, 0}, kCompliance, -1) == 0);
}

TEST_CASE("friction: sticks within the threshold, slips against the motion beyond it") {
  const Law law{LawKind::friction, 5};
  for (const double sign : {-1.0, 1.0}) {
    const double stick = law_force(law, kCompliance, sign * 0.03);
    CHECK(stick == doctest::Approx(-sign * 3));
    CHECK(std::abs(delta_at(stick, sign * 0.03)) < 1e-16);
    CHECK(law_force(law, kCompliance, sign * 0.05) == doctest::Approx(-sign * 5));
    CHECK(law_force(law, kCompliance, sign * 0.2) == doctest::Approx(-sign * 5));
  }
  CHECK(law_force({LawKind::friction, 0}, kCompliance, 0.2) == 0);
  CHECK(law_force({LawKind::friction, kInfinite}, kCompliance, 0.2) == doctest::Approx(-20));
}

TEST_CASE("viscous friction grows with the slip, and does not hinder sticking") {
  const Law law{LawKind::friction, 5, 40};
  for (const double sign : {-1.0, 1.0}) {
    CHECK(law_force(law, kCompliance, sign * 0.03) == doctest::Approx(-sign * 3));
    const double force = law_force(law, kCompliance, sign * 0.2);
    const double slip = delta_at(force, sign * 0.2);
    CHECK(slip * sign > 0);
    CHECK(force == doctest::Approx(-sign * 5 - 40 * slip));
  }
  const double force = law_force({LawKind::friction, 0, 40}, kCompliance, 0.2);  // viscosity alone
  CHECK(force == doctest::Approx(-40 * delta_at(force, 0.2)));
}

TEST_CASE("every force falls, and every displacement rises, with the free displacement; no graph jumps") {
  const Law laws[] = {{LawKind::bilateral},       {.kind = LawKind::bilateral, .compliance = 0.5},
                      {LawKind::unilateral, 5},   {LawKind::unilateral, kInfinite},
                      {LawKind::friction, 5},     {LawKind::friction, 5, 40},
                      {LawKind::friction, 0, 40}, {LawKind::friction, kInfinite, 40}};
  for (const Law& law : laws) {
    constexpr double kStep = 1e-4;
    for (double delta_bar = -0.2; delta_bar < 0.2; delta_bar += kStep) {
      const double force = law_force(law, kCompliance, delta_bar);
      const double next = law_force(law, kCompliance, delta_bar + kStep);
      CHECK(next <= force + 1e-12);
      CHECK(next >= force - kStep / kCompliance - 1e-12);
      CHECK(delta_at(next, delta_bar + kStep) >= delta_at(force, delta_bar) - 1e-15);
    }
  }
}

TEST_CASE("the disk's fixed points stick inside the disk and oppose the displacement on its rim") {
  Random random(1);
  for (int repeat = 0; repeat < 200; ++repeat) {
    const double radius = random.uniform(0, 3);
    const MatrixX g = random.matrix(2, 2);
    const Eigen::Matrix2d w = g * g.transpose() + 0.1 * Eigen::Matrix2d::Identity();
    const double bound = w.trace();
    const Eigen::Vector2d delta_free = random.matrix(2, 1);
    Eigen::Vector2d force(0, 0);
    for (int i = 0; i < 3000; ++i) force = disk_force(radius, bound, force, w * force + delta_free);
    const Eigen::Vector2d delta = w * force + delta_free;
    CHECK(force.norm() <= radius * (1 + 1e-14));
    if (force.norm() < radius * (1 - 1e-9)) {
      CHECK(delta.norm() < 1e-9);
    } else {
      CHECK(force.dot(delta) == doctest::Approx(-force.norm() * delta.norm()).epsilon(1e-9));
    }
  }
}

TEST_CASE("a disk without radius carries nothing") {
  CHECK(disk_force(0, 0.1, {1, 2}, {0.3, 0.4}).isZero(0));
  CHECK(disk_force(0, 0.1, {0, 0}, {0, 0}).isZero(0));
}

}  // namespace
}  // namespace acus
