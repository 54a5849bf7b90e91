// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/laws/friction_cone.h"

#include <doctest/doctest.h>

#include "server/engine/laws/solver/constraint_solver.h"
#include "server/engine/math/random.h"

namespace acus::test {
namespace {

using Eigen::Vector2d;

// The cone itself, its side chosen by the slip along.
Vector2d cone_force(const FrictionCone& cone, const Vector2d& slip) {
  const Vector2d axes(slip[0] < 0 ? cone.back : 1, 1);
  const Vector2d round = axes.cwiseProduct(slip);
  return -cone.law.force(slip.norm()) * axes.cwiseProduct(round.normalized());
}

DiskContact slipping(const FrictionCone& cone, const Vector2d& slip) {
  return {.force = cone_force(cone, slip), .slip = slip, .slips = true};
}

SlipLaw random_law(Random& random) {
  SlipLaw law{.threshold = random.uniform(0.01, 2), .viscosity = random.index(2) * random.uniform(0, 1e4)};
  if (random.index(2) == 0) law.thinning = random.uniform(1e-6, 1e-4), law.exponent = random.uniform(0, 1);
  return law;
}

FrictionCone random_cone(Random& random) {
  return {.law = random_law(random), .back = random.index(2) == 0 ? 1 : random.uniform(0.2, 2)};
}

MatrixX random_compliance(Random& random, int rows) {
  const MatrixX g = random.matrix(rows, rows);
  return 1e-3 * (g * g.transpose() + 0.1 * MatrixX::Identity(rows, rows));
}

// What (lambda, delta) violates the cone by (N), if it is held to be the answer of one; `at_rest`: a slip (m).
double violation(const FrictionCone& cone, const Vector2d& lambda, const Vector2d& delta, double at_rest = 1e-10) {
  const Vector2d round = lambda.cwiseQuotient(Vector2d(lambda[0] > 0 ? cone.back : 1, 1));
  if (delta.norm() < at_rest) return std::max(0.0, round.norm() - cone.law.force(delta.norm()));
  return (lambda - cone_force(cone, delta)).norm();
}

}  // namespace

TEST_CASE("the friction of a slip rises, ever less, with the slope that it says, from Coulomb's to a power") {
  Random random(7);
  for (int i = 0; i < 1000; ++i) {
    const SlipLaw law = random_law(random);
    const double slip = random.uniform(0, 1e-3), step = 1e-4 * slip;
    CHECK(law.force(0) == law.threshold);
    CHECK((law.force(slip + step) - law.force(slip - step)) / (2 * step) ==
          doctest::Approx(law.slope(slip)).epsilon(1e-6));
    CHECK(law.slope(slip) >= 0);
    CHECK(law.slope(slip) <= law.slope(0.9 * slip) * (1 + 1e-12));
    CHECK(law.slope(0) == law.viscosity);
  }
  const SlipLaw power{.viscosity = 1e4, .thinning = 1e-9, .exponent = 0.4};
  CHECK(power.force(2e-3) / power.force(1e-3) == doctest::Approx(std::pow(2, 0.4)).epsilon(1e-5));
  const SlipLaw ends{.threshold = 1, .viscosity = 1e4, .thinning = 1e-5};
  CHECK(ends.force(1) == doctest::Approx(1.1).epsilon(1e-5));
  CHECK(SlipLaw{.viscosity = 3, .thinning = 1e-5, .exponent = 1}.force(2) == 6);
}

TEST_CASE("a cone alone: it sticks within, else the force is that of the slip") {
  Random random(1);
  int stuck = 0, back = 0;
  double off_line = 0, off_cone = 0;  // m; -
  for (int i = 0; i < 2000; ++i) {
    const FrictionCone cone = random_cone(random);
    const Eigen::Matrix2d W = random_compliance(random, 2);
    const Vector2d bar = 1e-3 * Vector2d(random.matrix(2, 1));
    const DiskContact contact = cone_contact(cone, W, bar);
    CAPTURE(i);
    off_line = std::max(off_line, (contact.slip - (W * contact.force + bar)).norm());
    off_cone = std::max(off_cone, violation(cone, contact.force, contact.slip) / contact.force.norm());
    stuck += contact.slips ? 0 : 1;
    back += contact.slips && contact.slip[0] < 0 && cone.back != 1 ? 1 : 0;
    if (!contact.slips) CHECK(contact.slip.norm() < 1e-15);
  }
  MESSAGE("off its line by ", off_line, " m, off the cone by ", off_cone, " of the force");
  CHECK(off_line < 1e-15);
  CHECK(off_cone < 1e-12);
  CHECK(stuck > 200);
  CHECK(stuck < 1800);
  CHECK(back > 200);
}

TEST_CASE("a disk without radius is viscous alone, or nothing") {
  const Eigen::Matrix2d W = Vector2d(1e-3, 2e-3).asDiagonal();
  const DiskContact viscous = disk_contact({.viscosity = 1e3}, W, {1e-3, 1e-3});
  CHECK(viscous.slips);
  CHECK((viscous.force + 1e3 * viscous.slip).norm() < 1e-12);
  CHECK(disk_contact({}, W, {1e-3, 1e-3}).force.isZero(0));
}

TEST_CASE("a shaft that is drawn back has its share of the friction, at any speed") {
  const Eigen::Matrix2d W = 1e-5 * Eigen::Matrix2d::Identity();
  const SlipLaw law{.threshold = 0.5, .viscosity = 1e4, .thinning = 1e-5, .exponent = 0.3};
  const FrictionCone cone{.law = law, .back = 0.3};
  for (const double slip : {1e-6, 1e-5, 1e-3}) {
    const double in = law.force(slip);
    const Vector2d pushed = cone_contact(cone, W, {slip + 1e-5 * in, 0}).force;
    const Vector2d drawn = cone_contact(cone, W, {-slip - 1e-5 * 0.3 * in, 0}).force;
    CHECK(pushed[0] == doctest::Approx(-in).epsilon(1e-9));
    CHECK(drawn[0] == doctest::Approx(0.3 * in).epsilon(1e-9));
  }
  CHECK_FALSE(cone_contact(cone, W, {-0.149e-5, 0}).slips);
  CHECK(cone_contact(cone, W, {-0.151e-5, 0}).slips);
  CHECK_FALSE(cone_contact(cone, W, {0.499e-5, 0}).slips);
  // Spin in place turns round no force, however little it moves along.
  CHECK(cone_contact(cone, W, {1e-12, 1e-4}).force[1] ==
        doctest::Approx(cone_contact(cone, W, {-1e-12, 1e-4}).force[1]).epsilon(1e-6));
}

TEST_CASE("the tangent of a cone goes through its answer and turns with it") {
  Random random(2);
  double off = 0, off_slope = 0;  // m; -
  for (int i = 0; i < 1000; ++i) {
    FrictionCone cone = random_cone(random);
    if (cone.law.viscosity == 0) cone.law.viscosity = 10;  // else its force does not tell the size of the slip
    const Vector2d slip(random.uniform(-1e-4, 1e-4), random.uniform(-1e-4, 1e-4));
    const DiskContact answer = slipping(cone, slip);
    const ConeTangent tangent = cone_tangent(cone, answer, 1);
    REQUIRE(tangent.slips);
    CHECK(tangent.give(0, 1) == doctest::Approx(tangent.give(1, 0)).epsilon(1e-12));
    CHECK(tangent.give.selfadjointView<Eigen::Lower>().eigenvalues().minCoeff() > 0);
    off = std::max(off, (tangent.offset - tangent.give * answer.force - slip).norm());
    if (cone.back != 1) continue;
    const Vector2d step = 1e-5 * slip.norm() * Vector2d(random.matrix(2, 1)).normalized();
    const Vector2d change = cone_force(cone, slip + step) - cone_force(cone, slip - step);
    off_slope = std::max(off_slope, (2 * step + tangent.give * change).norm() / (2 * step.norm()));
  }
  MESSAGE("off the answer by ", off, " m, off the slope by ", off_slope);
  CHECK(off < 1e-14);
  CHECK(off_slope < 1e-2);
}

TEST_CASE("the tangent of a cone that sticks holds it; where its force has an end it gives a million times the rows") {
  const FrictionCone cone{.law = {.threshold = 2}};
  CHECK(cone_tangent(cone, {.force = {1, 1}}, 1e-3).give.isZero(0));
  const ConeTangent tangent = cone_tangent(cone, {.force = {-2, 0}, .slip = {1e-5, 0}, .slips = true}, 1e-3);
  CHECK(tangent.give(0, 0) == doctest::Approx(1e3));
  CHECK(tangent.give(1, 1) == doctest::Approx(1e-5 / 2));
}

// Points of a shaft that neither mesh nor beams can tell apart wind and slip by nanometres, as where a needle comes to
// rest: of the sweeps and rounds of laws of single rows hundreds were needed, or did not end.
TEST_CASE("Newton's method finds the forces of many cones in few picks, from whatever forces") {
  constexpr int kCones = 60, kModes = 20, kRows = 2 * kCones + 1;
  Random random(5);
  int most = 0;
  for (int i = 0; i < 60; ++i) {
    const MatrixX modes = random.matrix(kRows, kModes);
    const MatrixX W = 1e-4 * (modes * modes.transpose()) + 1e-6 * MatrixX::Identity(kRows, kRows);
    std::vector<FrictionCone> cones;
    cones.reserve(kCones);  // the laws refer to them
    std::vector<Law> laws{{LawKind::bilateral}};
    const bool flat = i % 3 == 0;  // forces that do not rise with the slip
    for (int k = 0; k < kCones; ++k) {
      cones.push_back(flat ? FrictionCone{.law = {.threshold = random.uniform(0.001, 0.01)}} : random_cone(random));
      for (const Law& law : laws_of_disk(cones.back())) laws.push_back(law);
    }
    std::vector<double> delta_free(kRows), lambda(kRows), delta(kRows);
    const VectorX free = random.uniform(1e-7, 1e-3) * (modes * random.matrix(kModes, 1));
    for (int k = 0; k < kRows; ++k) {
      delta_free[static_cast<std::size_t>(k)] = free[k];
      lambda[static_cast<std::size_t>(k)] = random.index(2) * random.uniform(-0.1, 0.1);
    }
    ConstraintSolver solver(kRows);
    const SolverResult result = solver.solve(LawMethod::direct, W, laws, delta_free, 1000, 1e-6, lambda, delta);
    CAPTURE(i);
    CHECK(result.converged);
    CHECK_FALSE(result.fell_back);
    most = std::max(most, result.steps.picks);
    for (int k = 0; k < kCones; ++k) {
      const auto row = static_cast<std::size_t>(1 + 2 * k);
      const Vector2d force(lambda[row], lambda[row + 1]), slip(delta[row], delta[row + 1]);
      // A force off by the tolerance moves a row by nanometres, and turns a slip of as many.
      CHECK(violation(cones[static_cast<std::size_t>(k)], force, slip, 1e-8) * std::max(slip.norm(), 1e-8) <
            1e-8 * force.norm() + 1e-14);
    }
  }
  MESSAGE("at most ", most, " picks");
  CHECK(most <= 16);
}

TEST_CASE("sweeps find the forces of many cones beside other laws") {
  constexpr int kCones = 5, kOthers = 3, kRows = 2 * kCones + kOthers;
  Random random(4);
  for (int i = 0; i < 50; ++i) {
    const MatrixX W = random_compliance(random, kRows);
    std::vector<FrictionCone> cones;
    cones.reserve(kCones);  // the laws refer to them
    std::vector<Law> laws{{LawKind::bilateral}, {LawKind::friction, 0.2}, {LawKind::unilateral, 1}};
    for (int k = 0; k < kCones; ++k) {
      cones.push_back(random_cone(random));
      for (const Law& law : laws_of_disk(cones.back())) laws.push_back(law);
    }
    std::vector<double> delta_free(kRows), lambda(kRows, 0.0), delta(kRows);
    for (double& d : delta_free) d = random.uniform(-2e-3, 2e-3);
    ConstraintSolver solver(kRows);
    const SolverResult result = solver.solve(LawMethod::gauss_seidel, W, laws, delta_free, 100000, 1e-9, lambda, delta);
    CHECK(result.converged);
    for (int k = 0; k < kCones; ++k) {
      const auto row = static_cast<std::size_t>(kOthers + 2 * k);
      CHECK(violation(cones[static_cast<std::size_t>(k)], {lambda[row], lambda[row + 1]},
                      {delta[row], delta[row + 1]}) < 1e-6);
    }
  }
}

}  // namespace acus::test
