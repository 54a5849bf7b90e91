// SPDX-License-Identifier: GPL-3.0-or-later
// The block-tridiagonal factor against the dense Cholesky factorisation.
#include "server/engine/math/factor/block_tridiagonal.h"

#include <doctest/doctest.h>

#include "server/engine/math/random.h"
#include "tests/support/dense.h"

namespace acus {
namespace {

MatrixX dense(const BlockTridiagonal& a) {
  MatrixX m = MatrixX::Zero(6 * a.blocks(), 6 * a.blocks());
  for (int i = 0; i < a.blocks(); ++i) {
    m.block<6, 6>(6 * i, 6 * i) = a.diagonal[i];
    if (i + 1 == a.blocks()) break;
    m.block<6, 6>(6 * (i + 1), 6 * i) = a.lower[i];
    m.block<6, 6>(6 * i, 6 * (i + 1)) = a.lower[i].transpose();
  }
  return m;
}

// A sum of element matrices GᵀG, as a chain of beams makes it, and some mass: positive definite.
BlockTridiagonal random_chain(int blocks, unsigned seed) {
  Random random(seed);
  BlockTridiagonal a;
  a.resize(blocks);
  for (int i = 0; i < blocks; ++i) {
    const MatrixX g = random.matrix(12, 12);
    const MatrixX element = g.transpose() * g;
    a.diagonal[i] += element.topLeftCorner<6, 6>() + 0.1 * Matrix6::Identity();
    if (i + 1 == blocks) continue;
    a.diagonal[i + 1] += element.bottomRightCorner<6, 6>();
    a.lower[i] = element.bottomLeftCorner<6, 6>();
  }
  return a;
}

TEST_CASE("forward and backward substitution are those of the dense Cholesky factor") {
  for (const int blocks : {1, 2, 3, 20}) {
    BlockTridiagonal a = random_chain(blocks, 10 + static_cast<unsigned>(blocks));
    REQUIRE(a.factorize());
    const MatrixX factor = test::cholesky_factor(dense(a));
    const VectorX b = Random(3).matrix(6 * blocks, 1);
    VectorX x = b;
    a.forward(x);
    CHECK((x - test::solve_dense(factor, b)).norm() < 1e-10 * x.norm());
    const VectorX y = x;
    a.backward(x);
    CHECK((x - test::solve_dense(factor.transpose(), y)).norm() < 1e-10 * x.norm());
    CHECK((dense(a) * x - b).norm() < 1e-10 * b.norm());
  }
}

TEST_CASE("a matrix that is not positive definite is refused, wherever the pivot fails") {
  for (const int block : {0, 5, 9}) {
    BlockTridiagonal a = random_chain(10, 6);
    a.diagonal[block](2, 2) -= 1e3;
    REQUIRE(test::eigenvalues(dense(a))[0] < 0);
    CHECK_FALSE(a.factorize());
  }
  // Positive diagonal blocks alone do not make it definite.
  BlockTridiagonal coupled;
  coupled.resize(2);
  for (Matrix6& block : coupled.diagonal) block.setIdentity();
  coupled.lower[0] = 1.1 * Matrix6::Identity();
  CHECK_FALSE(coupled.factorize());
}

TEST_CASE("a not-a-number is refused") {
  BlockTridiagonal a = random_chain(4, 7);
  a.diagonal[2](1, 1) = std::nan("");
  CHECK_FALSE(a.factorize());
}

TEST_CASE("the factor serves again after a new matrix is filled in") {
  BlockTridiagonal a = random_chain(8, 8);
  REQUIRE(a.factorize());
  const BlockTridiagonal other = random_chain(8, 9);
  a.set_zero();
  CHECK(dense(a).isZero(0));
  for (int i = 0; i < 8; ++i) a.diagonal[i] = other.diagonal[i];
  for (int i = 0; i < 7; ++i) a.lower[i] = other.lower[i];
  REQUIRE(a.factorize());
  const VectorX b = Random(10).matrix(48, 1);
  VectorX x = b;
  a.forward(x);
  a.backward(x);
  CHECK((dense(other) * x - b).norm() < 1e-10 * b.norm());
}

}  // namespace
}  // namespace acus
