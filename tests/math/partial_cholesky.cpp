// SPDX-License-Identifier: GPL-3.0-or-later
// Eliminating some unknowns of a dense matrix leaves their factor, the coupling and the Schur complement.
#include "server/engine/math/factor/partial_cholesky.h"

#include <doctest/doctest.h>

#include "server/engine/math/random.h"

namespace acus {
namespace {

MatrixX random_matrix(Eigen::Index n, Random& random) {
  const MatrixX g = random.matrix(n, n);
  return g * g.transpose() + 0.1 * MatrixX::Identity(n, n);
}

TEST_CASE("factor, coupling and Schur complement put the matrix together again") {
  Random random(1);
  for (const Eigen::Index n : {1, 2, 15, 16, 17, 50, 300}) {
    const MatrixX A = random_matrix(n, random);
    for (const Eigen::Index count : {Eigen::Index{0}, n / 3, n / 2, n}) {
      MatrixX worked = A;
      worked.triangularView<Eigen::StrictlyUpper>().setConstant(std::nan(""));
      REQUIRE(partial_cholesky(worked, count));
      MatrixX L = MatrixX::Zero(n, n), S = L;
      L.leftCols(count) = worked.leftCols(count).triangularView<Eigen::Lower>();
      S.bottomRightCorner(n - count, n - count) =
          worked.bottomRightCorner(n - count, n - count).selfadjointView<Eigen::Lower>();
      CHECK((L * L.transpose() + S - A).norm() < 1e-14 * A.norm());
    }
  }
}

TEST_CASE("a part of a larger matrix is worked on in its place") {
  Random random(2);
  const MatrixX A = random_matrix(40, random);
  MatrixX alone = A, large = MatrixX::Constant(60, 60, 7);
  large.topLeftCorner(40, 40) = A;
  REQUIRE(partial_cholesky(alone, 25));
  REQUIRE(partial_cholesky(large.topLeftCorner(40, 40), 25));
  CHECK(large.topLeftCorner(40, 40) == alone);
  CHECK(large.rightCols(20) == MatrixX::Constant(60, 20, 7));
}

TEST_CASE("mirrored, the lower triangle is on both sides") {
  Random random(4);
  for (const Eigen::Index n : {0, 1, 15, 16, 17, 50}) {
    const MatrixX A = random.matrix(n, n);
    MatrixX mirrored = A;
    mirror_lower(mirrored);
    CHECK(mirrored == MatrixX(A.selfadjointView<Eigen::Lower>()));
  }
}

TEST_CASE("a pivot that is not positive is told") {
  Random random(3);
  MatrixX A = random_matrix(30, random);
  A(20, 20) = -1;
  MatrixX before = A;
  CHECK(partial_cholesky(before, 20));  // not reached yet
  CHECK_FALSE(partial_cholesky(A, 30));
  MatrixX broken = random_matrix(5, random);
  broken(3, 3) = std::nan("");
  CHECK_FALSE(partial_cholesky(broken, 5));
}

}  // namespace
}  // namespace acus
