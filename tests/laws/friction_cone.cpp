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

double law_at(const Law& law, double slip) { return -std::copysign(law.limit, slip) - law.viscosity * slip; }

Vector2d laws_at(const ConeLaws& laws, const Vector2d& slip) {
  return {law_at(laws[0], slip[0]), law_at(laws[1], slip[1])};
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

// What (lambda, delta) violates the cone by (N), if it is held to be the answer of one.
double violation(const FrictionCone& cone, const Vector2d& lambda, const Vector2d& delta) {
  const Vector2d round = lambda.cwiseQuotient(Vector2d(lambda[0] > 0 ? cone.back : 1, 1));
  if (delta.norm() < 1e-10) return std::max(0.0, round.norm() - cone.law.force(delta.norm()));
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

TEST_CASE("at the slip of the contact the laws of the rows give the cone's force, and no more at smaller ones") {
  Random random(2);
  for (int i = 0; i < 1000; ++i) {
    const FrictionCone cone = random_cone(random);
    const Vector2d slip(random.uniform(-1e-4, 1e-4), random.uniform(-1e-4, 1e-4));
    const ConeLaws laws = laws_of_rows(cone, slipping(cone, slip));
    const Vector2d force = laws_at(laws, slip);
    CHECK((force - cone_force(cone, slip)).norm() < 1e-9 * force.norm());
    const Vector2d smaller = slip.cwiseProduct(Vector2d(random.uniform(0, 1), random.uniform(0, 1)));
    CHECK((laws_at(laws, smaller).cwiseAbs().array() <= force.cwiseAbs().array()).all());
  }
}

TEST_CASE("along a straight slip the law has the slope of the cone, from rest on") {
  Random random(3);
  for (int i = 0; i < 1000; ++i) {
    const FrictionCone cone = random_cone(random);
    for (const double slip : {random.uniform(-1e-4, 1e-4), random.uniform(-1e-7, 1e-7)}) {
      const Law along = laws_of_rows(cone, slipping(cone, {slip, 0}))[0];
      const double step = 1e-4 * std::abs(slip);
      const double slope = cone_force(cone, {slip - step, 0})[0] - cone_force(cone, {slip + step, 0})[0];
      CHECK(slope / (2 * step) == doctest::Approx(along.viscosity).epsilon(1e-5).scale(cone.law.viscosity + 1e-3));
    }
    const DiskContact stuck{.force = {-0.5 * cone.law.threshold, 0}};
    CHECK(laws_of_rows(cone, stuck)[0].viscosity == cone.law.viscosity);
    CHECK(laws_of_rows(cone, stuck)[0].limit == cone.law.threshold);
  }
}

TEST_CASE("without spin the law along is Coulomb's, and nothing holds the shaft about itself") {
  const FrictionCone cone{.law = {.threshold = 2, .viscosity = 3}};
  const auto [along, about] = laws_of_rows(cone, {.force = {-2, 0}, .slip = {1e-5, 0}, .slips = true});
  CHECK(along.limit == 2);
  CHECK(along.viscosity == 3);
  CHECK(about.limit == 0);
}

TEST_CASE("what sticks may bear both forces up to the circle") {
  const auto laws = [](double along, double about) {
    return laws_of_rows({.law = {.threshold = 2}}, {.force = {along, about}});
  };
  CHECK(laws(0, 0)[0].limit == 2);
  CHECK(laws(0, 0)[1].limit == 2);
  CHECK(laws(-1.2, 0)[1].limit == doctest::Approx(1.6));
  CHECK(laws(0, -1.6)[0].limit == doctest::Approx(1.2));
  CHECK(laws(3, 0)[1].limit == 0);
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
