// SPDX-License-Identifier: GPL-3.0-or-later
// The violation of a law is the force by which its row would still move.
#include "server/engine/laws/solver/law_system.h"

#include <doctest/doctest.h>

#include <cmath>
#include <vector>

#include "server/engine/math/random.h"
#include "tests/support/dense.h"

namespace acus {
namespace {

TEST_CASE("the residual is the force by which the worst row is off its graph") {
  const MatrixX W = MatrixX::Identity(3, 3);
  const std::vector<Law> laws{{LawKind::bilateral}, {LawKind::unilateral, 2}, {LawKind::friction, 1}};
  const Vector3 free = Vector3::Zero(), scale = Vector3::Ones();
  const LawSystem system{W, laws, {free.data(), 3}, {scale.data(), 3}};
  const auto residual = [&](Vector3 lambda, Vector3 delta) {
    return law_residual(system, {{lambda.data(), 3}, {delta.data(), 3}});
  };
  CHECK(residual({7, 0, 0.5}, {0, 1, 0}) == 0);
  CHECK(residual({7, 2, -1}, {0, -1, 1}) == 0);
  CHECK(residual({7, 0, 0}, {0.5, 0, 0}) == doctest::Approx(0.5));     // bilateral apart
  CHECK(residual({0, 0.25, 0}, {0, 1, 0}) == doctest::Approx(0.25));   // pulls while open
  CHECK(residual({0, 0, 0}, {0, -0.75, 0}) == doctest::Approx(0.75));  // pierces without force
  CHECK(residual({0, 0, 3}, {0, 0, 0}) == doctest::Approx(2));         // sticks above the threshold
  CHECK(residual({0, 0, 1}, {0, 0, 1}) == doctest::Approx(1));         // pushes along with the slip
  CHECK(std::isnan(residual({std::nan(""), 0, 3}, {0, 0, 0})));        // whatever comes after it
}

TEST_CASE("a disk's scale is no smaller than any eigenvalue of its block") {
  Random random(1);
  const std::vector<Law> laws{
      {LawKind::unilateral, 1}, {LawKind::disk_first, 1, 0, 0}, {LawKind::disk_second, 1, 0, 0}};
  for (int repeat = 0; repeat < 100; ++repeat) {
    const MatrixX g = random.matrix(3, 3), W = g * g.transpose();
    Vector3 scale;
    law_scales(W, laws, {scale.data(), 3});
    CHECK(scale[0] == W(0, 0));
    const Eigen::Matrix2d block = W.bottomRightCorner<2, 2>();
    CHECK(scale[1] >= test::eigenvalues(block)[1] * (1 - 1e-14));
  }
}

TEST_CASE("displacements are those of the forces") {
  Random random(2);
  const MatrixX W = random.matrix(4, 4);
  const VectorX free = random.matrix(4, 1);
  VectorX lambda = random.matrix(4, 1), delta(4);
  lambda[2] = 0;
  const std::vector<Law> laws(4);
  update_displacements({W, laws, {free.data(), 4}, {}}, {{lambda.data(), 4}, {delta.data(), 4}});
  CHECK((delta - W * lambda - free).norm() < 1e-15);
}

}  // namespace
}  // namespace acus
