// SPDX-License-Identifier: GPL-3.0-or-later
// The sparse factor and its substitutions against Eigen's dense Cholesky factorisation.
#include "server/math/sparse_cholesky.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstring>

#include "tests/support/random.h"

namespace acus {
namespace {

constexpr int kSide = 6;
constexpr int kUnknowns = 3 * kSide * kSide * kSide;

// Three unknowns per node of a cubic grid, coupled to the neighbours by random 3 x 3 blocks: like a tissue's matrix.
SparseMatrix grid_matrix(unsigned seed, double diagonal) {
  Random random(seed);
  const auto node = [](int i, int j, int k) { return (i * kSide + j) * kSide + k; };
  std::vector<Eigen::Triplet<double>> entries;
  const auto couple = [&](int a, int b) {
    for (int row = 0; row < 3; ++row)
      for (int column = 0; column < 3; ++column)
        entries.emplace_back(3 * std::max(a, b) + row, 3 * std::min(a, b) + column, random.uniform(-1, 1));
  };
  for (int i = 0; i < kSide; ++i)
    for (int j = 0; j < kSide; ++j)
      for (int k = 0; k < kSide; ++k) {
        if (i + 1 < kSide) couple(node(i, j, k), node(i + 1, j, k));
        if (j + 1 < kSide) couple(node(i, j, k), node(i, j + 1, k));
        if (k + 1 < kSide) couple(node(i, j, k), node(i, j, k + 1));
      }
  for (int i = 0; i < kUnknowns; ++i) entries.emplace_back(i, i, diagonal + random.uniform(0, 1));
  SparseMatrix lower(kUnknowns, kUnknowns);
  lower.setFromTriplets(entries.begin(), entries.end());
  return lower;
}

// Diagonally dominant: the blocks of a node's six neighbours have at most 18 entries of size 1 per row.
SparseMatrix definite_matrix(unsigned seed) { return grid_matrix(seed, 18); }

MatrixX dense(const SparseMatrix& lower) { return MatrixX(MatrixX(lower).selfadjointView<Eigen::Lower>()); }

VectorX permuted(const SparseCholesky& factor, const VectorX& x) {
  VectorX y(x.size());
  for (int i = 0; i < factor.size(); ++i) y[factor.position(i)] = x[i];
  return y;
}

VectorX unpermuted(const SparseCholesky& factor, const VectorX& y) {
  VectorX x(y.size());
  for (int i = 0; i < factor.size(); ++i) x[i] = y[factor.position(i)];
  return x;
}

SparseCholesky factor_of(const SparseMatrix& lower) {
  SparseCholesky factor;
  factor.analyze(lower);
  REQUIRE(factor.factorize(lower));
  return factor;
}

bool same_bits(const VectorX& a, const VectorX& b) {
  return a.size() == b.size() &&
         std::memcmp(a.data(), b.data(), sizeof(double) * static_cast<std::size_t>(a.size())) == 0;
}

TEST_CASE("positions are a permutation") {
  const SparseCholesky factor = factor_of(definite_matrix(1));
  CHECK(factor.size() == kUnknowns);
  CHECK(factor.factor_entries() >= static_cast<std::size_t>(definite_matrix(1).nonZeros()));
  std::vector<bool> seen(kUnknowns, false);
  for (int i = 0; i < kUnknowns; ++i) seen[static_cast<std::size_t>(factor.position(i))] = true;
  CHECK(std::count(seen.begin(), seen.end(), true) == kUnknowns);
}

TEST_CASE("forward and backward substitution are those of the dense factor of the permuted matrix") {
  const SparseMatrix a = definite_matrix(2);
  const SparseCholesky factor = factor_of(a);
  MatrixX reordered(kUnknowns, kUnknowns);
  const MatrixX whole = dense(a);
  for (int i = 0; i < kUnknowns; ++i)
    for (int j = 0; j < kUnknowns; ++j) reordered(factor.position(i), factor.position(j)) = whole(i, j);
  const Eigen::LLT<MatrixX> oracle(reordered);
  const VectorX b = permuted(factor, Random(3).matrix(kUnknowns, 1));
  VectorX y = b;
  factor.forward(y);
  CHECK((y - oracle.matrixL().solve(b)).norm() < 1e-12 * y.norm());
  VectorX x = y;
  factor.backward(x);
  CHECK((x - oracle.matrixU().solve(y)).norm() < 1e-12 * x.norm());
  CHECK((whole * unpermuted(factor, x) - unpermuted(factor, b)).norm() < 1e-12 * b.norm());
}

TEST_CASE("three right-hand sides at once are three single ones") {
  const SparseCholesky factor = factor_of(definite_matrix(4));
  Eigen::MatrixX3d together = Random(5).matrix(kUnknowns, 3);
  MatrixX single = together;
  factor.forward3(together);
  for (int k = 0; k < 3; ++k) factor.forward(single.col(k));
  CHECK((together - single).norm() < 1e-14 * single.norm());
}

TEST_CASE("columns before the first entry may be skipped") {
  const SparseCholesky factor = factor_of(definite_matrix(6));
  for (const int first : {0, 1, 100, 333, kUnknowns - 1}) {
    VectorX whole = VectorX::Zero(kUnknowns);
    whole.tail(kUnknowns - first) = Random(7).matrix(kUnknowns - first, 1);
    VectorX late = whole;
    Eigen::MatrixX3d late3 = Eigen::MatrixX3d::Zero(kUnknowns, 3);
    late3.col(1) = whole;
    factor.forward(whole);
    factor.forward(late, first);
    factor.forward3(late3, first);
    CHECK((late - whole).norm() < 1e-14 * whole.norm());
    CHECK((late3.col(1) - whole).norm() < 1e-14 * whole.norm());
    CHECK(late3.col(0).isZero(0));
    CHECK(late3.col(2).isZero(0));
  }
}

TEST_CASE("a unit right-hand side fills only what it must, and exactly so") {
  const SparseMatrix a = definite_matrix(8);
  const SparseCholesky factor = factor_of(a);
  const MatrixX inverse = dense(a).inverse();
  for (const int unknown : {0, 17, 320, kUnknowns - 1}) {
    const int row = factor.position(unknown);
    Eigen::MatrixX3d x = Eigen::MatrixX3d::Zero(kUnknowns, 3);
    x(row, 0) = 1;
    factor.forward3(x, row);
    CHECK(x.col(0).head(row).isZero(0));
    CHECK(x.col(0).squaredNorm() == doctest::Approx(inverse(unknown, unknown)).epsilon(1e-12));
  }
}

TEST_CASE("the same matrix and right-hand side give the same bits, again and in another factor") {
  const SparseMatrix a = definite_matrix(9);
  SparseCholesky factor = factor_of(a);
  const VectorX b = permuted(factor, Random(10).matrix(kUnknowns, 1));
  VectorX x = b;
  factor.forward(x);
  factor.backward(x);

  REQUIRE(factor.factorize(definite_matrix(11)));  // something else in between
  REQUIRE(factor.factorize(a));
  const SparseCholesky fresh = factor_of(a);
  for (const SparseCholesky* again : {static_cast<const SparseCholesky*>(&factor), &fresh}) {
    VectorX y = b;
    again->forward(y);
    again->backward(y);
    CHECK(same_bits(x, y));
  }
}

TEST_CASE("an indefinite matrix is refused and the next definite one accepted") {
  SparseCholesky factor = factor_of(definite_matrix(12));
  SparseMatrix indefinite = definite_matrix(12);
  indefinite.coeffRef(300, 300) = -1;
  CHECK_FALSE(factor.factorize(indefinite));
  CHECK_FALSE(factor.factorize(grid_matrix(13, 0)));

  const SparseMatrix a = definite_matrix(14);
  REQUIRE(factor.factorize(a));
  const VectorX b = Random(15).matrix(kUnknowns, 1);
  VectorX x = permuted(factor, b);
  factor.forward(x);
  factor.backward(x);
  CHECK((dense(a) * unpermuted(factor, x) - b).norm() < 1e-12 * b.norm());
}

}  // namespace
}  // namespace acus
