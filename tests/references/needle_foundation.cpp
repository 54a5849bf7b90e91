// SPDX-License-Identifier: GPL-3.0-or-later
// A needle in tissue is a beam on an elastic foundation: its shaft rows hold it by k per length and displacement.
//
// Source: M. Hetényi, "Beams on Elastic Foundation" (1946), sec. 6. With lambda = (k/4EI)^1/4 the semi-infinite beam is
// y = exp(-lambda x)(C cos(lambda x) + D sin(lambda x)); outside, between the base and the surface, it is a cubic. The
// base is moved aside without turning; deflection, slope, moment and shear are continuous at the surface. The needle
// ends at lambda D = 6.4, where exp(-6.4) is left of the deflection.
//
// The tissue is rigid, so that k is what the scene says: `foundation_stiffness`.
#include <numbers>

#include "tests/references/figure.h"
#include "tests/references/rigid_ground.h"
#include "tests/support/dense.h"

namespace acus::test {
namespace {

constexpr double kDepth = 0.08, kAside = 1e-4;  // m
constexpr double kLambda = 80;                  // 1/m

struct BaseLoad {
  double force, moment;  // N, N m, of the needle on its holder, positive against the motion
};

// Of the free length a outside and stiffness EI.
BaseLoad hetenyi(double a, double bending) {
  // y = kAside + c2 (x + a)² + c3 (x + a)³ for x < 0. Unknowns c2, c3, C, D; rows y, y', y'', y''' at x = 0.
  const double l = kLambda;
  Eigen::Matrix4d m;
  m << a * a, a * a * a, -1, 0,  //
      2 * a, 3 * a * a, l, -l,   //
      2, 6 * a, 0, 2 * l * l,    //
      0, 6, -2 * l * l * l, -2 * l * l * l;
  const Eigen::Vector4d c = solve_dense(m, Eigen::Vector4d(-kAside, 0, 0, 0));
  return {6 * bending * c[1], -2 * bending * c[0]};
}

BaseLoad move_aside(double spacing, double& outside, double& bending) {
  Scene scene = rigid_ground();
  Needle& needle = scene.needles[0];
  needle.beams = 100;
  needle.constraint_spacing = spacing;
  bending = bending_stiffness(needle);
  Interaction& law = scene.tissue.regions[0].interaction;
  law = {.puncture_force = 1e-3, .cutting_force = 0, .pressure = 0, .foundation_stiffness = {}};
  law.foundation_stiffness = 4 * bending * std::pow(kLambda, 4);
  Bench bench(scene);
  bench.push(0, kDepth + 1e-4, 0.2);
  bench.wait(0.2);
  outside = needle.length - bench.needle().inserted_depth;
  bench.move(0, {0, kAside, 0}, 1e-3);
  bench.wait(0.3);
  CHECK(bench.flags() == 0);
  const NeedleReport& report = bench.needle();
  return {-report.base_force.y(), -report.base_torque.x()};
}

TEST_CASE("a needle in its path, moved aside at its base, bears what Hetényi's beam does") {
  // Vertices share the foundation out as the trapezoidal rule does: order two in their spacing.
  BaseLoad found[2], exact{};
  for (int i = 0; i < 2; ++i) {
    double outside, bending;
    found[i] = move_aside(i == 0 ? 4e-3 : 2e-3, outside, bending);
    exact = hetenyi(outside, bending);
  }
  CHECK(agrees("foundation, spacing 4 mm, base force (N)", exact.force, found[0].force, 0.025 * exact.force));
  CHECK(agrees("foundation, spacing 2 mm, base force (N)", exact.force, found[1].force, 0.006 * exact.force));
  CHECK(agrees("foundation, spacing 2 mm, base moment (N m)", exact.moment, found[1].moment, 0.004 * exact.moment));
  const double order = observed_order(found[0].force - exact.force, found[1].force - exact.force);
  CHECK(agrees("foundation, order in the spacing", 2, order, 0.02));
}

}  // namespace
}  // namespace acus::test
