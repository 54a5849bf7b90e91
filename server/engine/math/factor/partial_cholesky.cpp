// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/math/factor/partial_cholesky.h"

#include <algorithm>
#include <cmath>

namespace acus {

namespace {

constexpr Eigen::Index kPanel = 16;
constexpr Eigen::Index kTile = 192;

using Block = Eigen::Ref<MatrixX>;

// The panel's columns, diagonal block and all below it, one column after the other.
bool factorize_panel(Block panel) {
  for (Eigen::Index k = 0; k < panel.cols(); ++k) {
    auto column = panel.col(k).tail(panel.rows() - k);
    for (Eigen::Index j = 0; j < k; ++j) column -= panel(k, j) * panel.col(j).tail(panel.rows() - k);
    const double pivot = column[0];
    if (!(pivot > 0) || !std::isfinite(pivot)) return false;
    column *= 1 / std::sqrt(pivot);
  }
  return true;
}

// rest <- rest - below belowᵀ, lower triangle.
void update(Block rest, const Eigen::Ref<const MatrixX>& below) {
  for (Eigen::Index j = 0; j < rest.cols(); j += kTile) {
    const Eigen::Index width = std::min(kTile, rest.cols() - j);
    const auto right = below.middleRows(j, width);
    rest.block(j, j, width, width).selfadjointView<Eigen::Lower>().rankUpdate(right, -1);
    for (Eigen::Index i = j + width; i < rest.rows(); i += kTile) {
      const Eigen::Index height = std::min(kTile, rest.rows() - i);
      rest.block(i, j, height, width).noalias() -= below.middleRows(i, height) * right.transpose();
    }
  }
}

}  // namespace

bool partial_cholesky(Eigen::Ref<MatrixX> A, Eigen::Index count) {
  for (Eigen::Index k = 0; k < count; k += kPanel) {
    const Eigen::Index width = std::min(kPanel, count - k), rest = A.rows() - k - width;
    if (!factorize_panel(A.block(k, k, width + rest, width))) return false;
    update(A.bottomRightCorner(rest, rest), A.block(k + width, k, rest, width));
  }
  return true;
}

void cholesky_solve(const Eigen::Ref<const MatrixX>& L, Eigen::Ref<VectorX> x) {
  L.triangularView<Eigen::Lower>().solveInPlace(x);
  L.transpose().triangularView<Eigen::Upper>().solveInPlace(x);
}

// Square by square, so that what is read across columns is still near when the next column asks for it.
void mirror_lower(Eigen::Ref<MatrixX> A) {
  constexpr Eigen::Index kSquare = 16;
  for (Eigen::Index j = 0; j < A.cols(); j += kSquare) {
    const Eigen::Index width = std::min(kSquare, A.cols() - j);
    auto corner = A.block(j, j, width, width);
    corner.triangularView<Eigen::StrictlyUpper>() = corner.transpose();
    for (Eigen::Index i = j + width; i < A.rows(); i += kSquare) {
      const Eigen::Index height = std::min(kSquare, A.rows() - i);
      A.block(j, i, width, height) = A.block(i, j, height, width).transpose();
    }
  }
}

void gather_lower(const Eigen::Ref<const MatrixX>& W, std::span<const int> rows, Eigen::Ref<MatrixX> out) {
  const auto n = static_cast<Eigen::Index>(rows.size());
  for (Eigen::Index j = 0; j < n; ++j) {
    const double* from = W.col(rows[j]).data();
    double* to = out.col(j).data();
    for (Eigen::Index i = j; i < n; ++i) to[i] = from[rows[i]];
  }
}

}  // namespace acus
