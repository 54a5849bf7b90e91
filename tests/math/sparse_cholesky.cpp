// SPDX-License-Identifier: GPL-3.0-or-later
// The sparse factor and its substitutions against Eigen's dense Cholesky factorisation.
#include "server/engine/math/factor/sparse_cholesky.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstring>

#include "server/engine/math/random.h"
#include "tests/support/dense.h"

namespace acus {
namespace {

constexpr int kSide = 6;
constexpr int kUnknowns = 3 * kSide * kSide * kSide;

// Three unknowns per node of a cubic grid, coupled to each other and to the neighbours by random numbers: like a tissue's matrix.
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
  for (int i = 0; i < kUnknowns; ++i) {
    entries.emplace_back(i, i, diagonal + random.uniform(0, 1));
    for (int j = i - i % 3; j < i; ++j) entries.emplace_back(i, j, random.uniform(-1, 1));
  }
  SparseMatrix lower(kUnknowns, kUnknowns);
  lower.setFromTriplets(entries.begin(), entries.end());
  return lower;
}

// Diagonally dominant: the blocks of a node and its six neighbours have at most 20 other entries of size 1 per row.
SparseMatrix definite_matrix(unsigned seed) { return grid_matrix(seed, 20); }

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

SparseCholesky factor_of(const SparseMatrix& lower, int block = 1, Precision precision = Precision::double_precision) {
  SparseCholesky factor;
  factor.analyze(lower, block);
  REQUIRE(factor.factorize(lower));
  factor.keep(precision);
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
  const MatrixX expected = test::cholesky_factor(reordered);
  const VectorX b = permuted(factor, Random(3).matrix(kUnknowns, 1));
  MatrixX panel_rows = factor.make_panel_rows();
  VectorX y = b;
  factor.forward(y, panel_rows);
  CHECK((y - test::solve_dense(expected, b)).norm() < 1e-12 * y.norm());
  VectorX x = y;
  factor.backward(x, panel_rows);
  CHECK((x - test::solve_dense(expected.transpose(), y)).norm() < 1e-12 * x.norm());
  CHECK((whole * unpermuted(factor, x) - unpermuted(factor, b)).norm() < 1e-12 * b.norm());
}

TEST_CASE("substitutions in parts of any size have the bits of the whole") {
  const SparseMatrix a = definite_matrix(6);
  for (const Precision precision :
       {Precision::half_precision, Precision::single_precision, Precision::double_precision}) {
    const SparseCholesky factor = factor_of(a, 3, precision);
    MatrixX panel_rows = factor.make_panel_rows();
    const VectorX b = Random(7).matrix(kUnknowns, 1);
    VectorX forward = b, backward = b;
    factor.forward(forward, panel_rows);
    factor.backward(backward, panel_rows);
    std::size_t most = 0;
    for (const double entries : {1.0, 100.0, 1000.0, 1e9}) {
      const std::vector<SparseCholesky::Part> parts = factor.parts(entries);
      most = std::max(most, parts.size());
      double sum = 0;
      VectorX y = b, x = b;
      for (const auto& part : parts) {
        factor.forward(part, y, panel_rows);
        sum += factor.entries(part);
      }
      for (auto part = parts.rbegin(); part != parts.rend(); ++part) factor.backward(*part, x, panel_rows);
      CHECK(same_bits(y, forward));
      CHECK(same_bits(x, backward));
      CHECK(sum == factor.entries(factor.parts(1e9).front()));
    }
    CHECK(most > 30);
  }
}

// A column of L⁻¹ at its full length, from the way that unit_columns() writes.
VectorX unfolded(const SparseCholesky& factor, int position, const VectorX& way) {
  const PanelTree& tree = factor.tree();
  VectorX column = VectorX::Zero(factor.size());
  int done = 0;
  for (int p = tree.panel_of[static_cast<std::size_t>(position)]; p >= 0; p = tree.panels[static_cast<std::size_t>(p)].parent) {
    const PanelTree::Panel& panel = tree.panels[static_cast<std::size_t>(p)];
    column.segment(panel.first, panel.columns) = way.segment(done, panel.columns);
    done += panel.columns;
  }
  return column;
}

TEST_CASE("unit columns are the forward substitutions of unit vectors, in all precisions") {
  const SparseMatrix a = definite_matrix(4);
  for (const Precision precision :
       {Precision::half_precision, Precision::single_precision, Precision::double_precision}) {
    const SparseCholesky factor = factor_of(a, 3, precision);
    MatrixX panel_rows = factor.make_panel_rows();
    Eigen::MatrixX3d columns = Eigen::MatrixX3d::Constant(factor.tree().longest_way, 3, 9.0);
    for (const int node : {0, 5, 100, kUnknowns / 3 - 1}) {
      const int position = factor.position(3 * node);
      factor.unit_columns(position, columns, panel_rows);
      for (int k = 0; k < 3; ++k) {
        VectorX whole = VectorX::Unit(kUnknowns, position + k);
        factor.forward(whole, panel_rows);
        CHECK((unfolded(factor, position, columns.col(k)) - whole).norm() < 1e-14 * whole.norm());
      }
    }
  }
}

TEST_CASE("the columns of a node carry the diagonal block of the inverse") {
  const SparseMatrix a = definite_matrix(8);
  const SparseCholesky factor = factor_of(a, 3);
  const MatrixX inverse = test::inverse(dense(a));
  MatrixX panel_rows = factor.make_panel_rows();
  Eigen::MatrixX3d columns(factor.tree().longest_way, 3);
  for (const int node : {0, 17, 71}) {
    const int position = factor.position(3 * node);
    factor.unit_columns(position, columns, panel_rows);
    const int panel = factor.tree().panel_of[static_cast<std::size_t>(position)];
    const auto way = columns.topRows(factor.tree().panels[static_cast<std::size_t>(panel)].to_root);
    CHECK((way.transpose() * way - inverse.block<3, 3>(3 * node, 3 * node)).norm() < 1e-12 * inverse.norm());
  }
}

TEST_CASE("blocks of unknowns stay together") {
  const SparseCholesky factor = factor_of(definite_matrix(6), 3);
  for (int i = 0; i < kUnknowns; i += 3) {
    CHECK(factor.position(i + 1) == factor.position(i) + 1);
    CHECK(factor.position(i + 2) == factor.position(i) + 2);
  }
}

TEST_CASE("in the tree every row below a panel belongs to a panel on its way to the root") {
  const SparseCholesky factor = factor_of(definite_matrix(7));
  const PanelTree& tree = factor.tree();
  for (int s = 0; s < static_cast<int>(tree.panels.size()); ++s) {
    const PanelTree::Panel& panel = tree.panels[static_cast<std::size_t>(s)];
    int entries = 0;
    std::vector<bool> on_way(tree.panels.size(), false);
    for (int p = s; p >= 0; p = tree.panels[static_cast<std::size_t>(p)].parent) {
      on_way[static_cast<std::size_t>(p)] = true;
      entries += tree.panels[static_cast<std::size_t>(p)].columns;
      CHECK(tree.meeting(s, p) == p);
      CHECK(tree.meeting(p, s) == p);
    }
    CHECK(panel.to_root == entries);
    for (int i = 0; i < panel.below; ++i) {
      const int row = tree.rows[static_cast<std::size_t>(panel.first_row + i)];
      CHECK(row >= panel.first + panel.columns);
      CHECK(on_way[static_cast<std::size_t>(tree.panel_of[static_cast<std::size_t>(row)])]);
    }
  }
}

// `least` and `most`: of the residual that rounding leaves, of the right-hand side.
void check_rounded(const SparseMatrix& a, Precision precision, double least, double most, std::size_t bytes_of_entry) {
  const SparseCholesky factor = factor_of(a, 1, precision);
  CHECK(factor.precision() == precision);
  CHECK(factor.factor_bytes() == factor.factor_entries() * bytes_of_entry);
  // L as rounded, column by column, and from it the matrix that it belongs to.
  MatrixX panel_rows = factor.make_panel_rows();
  MatrixX inverse(kUnknowns, kUnknowns);
  for (int i = 0; i < kUnknowns; ++i) {
    VectorX column = VectorX::Unit(kUnknowns, i);
    factor.forward(column, panel_rows);
    inverse.col(i) = column;
  }
  const VectorX b = Random(17).matrix(kUnknowns, 1);
  VectorX x = b;
  factor.forward(x, panel_rows);
  factor.backward(x, panel_rows);
  CHECK((x - inverse.transpose() * (inverse * b)).norm() < 1e-13 * x.norm());

  const VectorX residual = dense(a) * unpermuted(factor, x) - unpermuted(factor, b);
  CHECK(residual.norm() < most * b.norm());
  CHECK(residual.norm() > least * b.norm());
}

TEST_CASE("in fewer bits the substitutions are exact ones of a matrix that is off by rounding") {
  check_rounded(definite_matrix(16), Precision::single_precision, 1e-9, 1e-6, 4);
  check_rounded(definite_matrix(16), Precision::half_precision, 1e-5, 2e-3, 2);
}

// Half of the unknowns are a thousand times stiffer than the others, all of them by `size`.
SparseMatrix scaled_matrix(double size) {
  SparseMatrix a = definite_matrix(18);
  const auto scale = [size](Eigen::Index i) { return std::sqrt(i < kUnknowns / 2 ? size : 1000 * size); };
  for (int column = 0; column < kUnknowns; ++column)
    for (SparseMatrix::InnerIterator entry(a, column); entry; ++entry)
      entry.valueRef() *= scale(entry.row()) * scale(column);
  return a;
}

TEST_CASE("half precision has room for stiffness of any size") {
  for (const double size : {1e-12, 1.0, 1e12})
    check_rounded(scaled_matrix(size), Precision::half_precision, 1e-5, 2e-3, 2);
}

TEST_CASE("unit columns made by and by have the bits of those made at once") {
  const SparseMatrix a = definite_matrix(19);
  for (const Precision precision : {Precision::half_precision, Precision::double_precision}) {
    const SparseCholesky factor = factor_of(a, 3, precision);
    MatrixX panel_rows = factor.make_panel_rows();
    Eigen::MatrixX3d whole(factor.tree().longest_way, 3), parts(whole.rows(), 3);
    for (const int node : {0, 5, 100, kUnknowns / 3 - 1}) {
      whole.setZero();
      parts.setZero();
      factor.unit_columns(factor.position(3 * node), whole, panel_rows);
      SparseCholesky::OnWay at = factor.begin_unit_columns(factor.position(3 * node), parts);
      int calls = 0;
      double left = 0;
      for (; at.panel >= 0; ++calls) {
        left += 500;
        factor.go_on(at, left, parts, panel_rows);
      }
      CHECK(calls > 1);
      CHECK(std::memcmp(whole.data(), parts.data(), sizeof(double) * static_cast<std::size_t>(whole.size())) == 0);
    }
  }
}

TEST_CASE("the same matrix and right-hand side give the same bits, again and in another factor") {
  const SparseMatrix a = definite_matrix(9);
  SparseCholesky factor = factor_of(a);
  const VectorX b = permuted(factor, Random(10).matrix(kUnknowns, 1));
  MatrixX panel_rows = factor.make_panel_rows();
  VectorX x = b;
  factor.forward(x, panel_rows);
  factor.backward(x, panel_rows);

  for (const SparseMatrix& matrix : {definite_matrix(11), a}) {
    REQUIRE(factor.factorize(matrix));
    factor.keep(Precision::double_precision);
  }
  const SparseCholesky fresh = factor_of(a);
  for (const SparseCholesky* again : {static_cast<const SparseCholesky*>(&factor), &fresh}) {
    VectorX y = b;
    again->forward(y, panel_rows);
    again->backward(y, panel_rows);
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
  factor.keep(Precision::double_precision);
  const VectorX b = Random(15).matrix(kUnknowns, 1);
  MatrixX panel_rows = factor.make_panel_rows();
  VectorX x = permuted(factor, b);
  factor.forward(x, panel_rows);
  factor.backward(x, panel_rows);
  CHECK((dense(a) * unpermuted(factor, x) - b).norm() < 1e-12 * b.norm());
}

}  // namespace
}  // namespace acus
