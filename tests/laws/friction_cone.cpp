// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/laws/friction_cone.h"

#include <doctest/doctest.h>

#include "server/engine/laws/solver/constraint_solver.h"
#include "server/engine/math/random.h"

namespace acus::test {
namespace {

using Eigen::Vector2d;

// The cone itself.
Vector2d cone_force(const FrictionCone& cone, const Vector2d& slip) {
  return -(cone.threshold / slip.norm() + cone.viscosity) * slip;
}

double law_at(const Law& law, double slip) { return -std::copysign(law.limit, slip) - law.viscosity * slip; }

Vector2d laws_at(const ConeLaws& laws, const Vector2d& slip) {
  return {law_at(laws[0], slip[0]), law_at(laws[1], slip[1])};
}

FrictionCone random_cone(Random& random, double viscosity) {
  return {.threshold = random.uniform(0.01, 2), .viscosity = random.index(2) * random.uniform(0, viscosity)};
}

MatrixX random_compliance(Random& random, int rows) {
  const MatrixX g = random.matrix(rows, rows);
  return 1e-3 * (g * g.transpose() + 0.1 * MatrixX::Identity(rows, rows));
}

// What (lambda, delta) violates the cone by (N), if it is held to be the answer of one.
double violation(const FrictionCone& cone, const Vector2d& lambda, const Vector2d& delta) {
  const Vector2d dry = lambda + cone.viscosity * delta;
  if (delta.norm() < 1e-10) return std::max(0.0, dry.norm() - cone.threshold);
  return (lambda - cone_force(cone, delta)).norm();
}

}  // namespace

TEST_CASE("a disk alone: it sticks within its circle, else the force is that of the slip") {
  Random random(1);
  int stuck = 0;
  for (int i = 0; i < 2000; ++i) {
    const FrictionCone cone = random_cone(random, 1e4);
    const Eigen::Matrix2d W = random_compliance(random, 2);
    const Vector2d bar = 1e-3 * Vector2d(random.matrix(2, 1));
    const DiskContact contact = disk_contact(cone.threshold, cone.viscosity, W, bar);
    CHECK((contact.slip - (W * contact.force + bar)).norm() < 1e-15);
    if (contact.slips) {
      CHECK((contact.force - cone_force(cone, contact.slip)).norm() < 1e-9 * contact.force.norm());
    } else {
      ++stuck;
      CHECK(contact.slip.norm() < 1e-15);
      CHECK(contact.force.norm() <= cone.threshold);
    }
  }
  CHECK(stuck > 200);
  CHECK(stuck < 1800);
}

TEST_CASE("a disk without radius is viscous alone, or nothing") {
  const Eigen::Matrix2d W = Vector2d(1e-3, 2e-3).asDiagonal();
  const DiskContact viscous = disk_contact(0, 1e3, W, {1e-3, 1e-3});
  CHECK(viscous.slips);
  CHECK((viscous.force + 1e3 * viscous.slip).norm() < 1e-12);
  CHECK(disk_contact(0, 0, W, {1e-3, 1e-3}).force.isZero(0));
}

TEST_CASE("at the slip of the contact the laws of the rows give the cone's force, and no more at smaller ones") {
  Random random(2);
  for (int i = 0; i < 1000; ++i) {
    const FrictionCone cone = random_cone(random, 1e3);
    const Vector2d slip(random.uniform(-1e-4, 1e-4), random.uniform(-1e-4, 1e-4));
    const DiskContact contact{.force = cone_force(cone, slip), .slip = slip, .slips = true};
    const Vector2d force = laws_at(laws_of_rows(cone, contact), slip);
    CHECK((force - contact.force).norm() < 1e-9 * force.norm());
    const Vector2d smaller = slip.cwiseProduct(Vector2d(random.uniform(0, 1), random.uniform(0, 1)));
    const Vector2d less = laws_at(laws_of_rows(cone, contact), smaller);
    CHECK((less.cwiseAbs().array() <= force.cwiseAbs().array()).all());
  }
}

TEST_CASE("with their whole share the laws of the rows have the slope of the cone") {
  Random random(3);
  for (int i = 0; i < 1000; ++i) {
    const FrictionCone cone = random_cone(random, 1e3);
    const Vector2d slip(random.uniform(-1e-4, 1e-4), random.uniform(-1e-4, 1e-4));
    const ConeLaws laws = laws_of_rows(cone, {.force = cone_force(cone, slip), .slip = slip, .slips = true}, 1);
    const double step = 1e-4 * slip.norm();
    for (int k = 0; k < 2; ++k) {
      const Vector2d by = step * Vector2d::Unit(k);
      const double slope = (cone_force(cone, slip + by) - cone_force(cone, slip - by))[k] / (2 * step);
      CHECK(-slope == doctest::Approx(laws[static_cast<std::size_t>(k)].viscosity).epsilon(1e-5));
    }
  }
}

TEST_CASE("without spin the law along is Coulomb's, and nothing holds the shaft about itself") {
  const FrictionCone cone{.threshold = 2, .viscosity = 3};
  const auto [along, about] = laws_of_rows(cone, {.force = {-2, 0}, .slip = {1e-5, 0}, .slips = true});
  CHECK(along.limit == 2);
  CHECK(along.viscosity == 3);
  CHECK(about.limit == 0);
}

TEST_CASE("what sticks may bear both forces up to the circle") {
  const auto laws = [](double along, double about) {
    return laws_of_rows({.threshold = 2}, {.force = {along, about}});
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
    std::vector<Law> laws{{LawKind::bilateral}, {LawKind::friction, 0.2}, {LawKind::unilateral, 1}};
    for (int k = 0; k < kCones; ++k) {
      cones.push_back(random_cone(random, 1e3));
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
