// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/models/field/low_modes.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace acus {

namespace {

constexpr int kBlock = 12;            // affine motions
constexpr int kVectorsPerMode = 3;    // of the space
constexpr double kIndependent = 1e-10;  // share of the longest vector's square that one has to add

// The affine motions, with waves on them: those of a symmetric body alone would never meet its other motions.
MatrixX affine_motions(const Matrix3X& places) {
  const Vector3 low = places.rowwise().minCoeff(), extent = places.rowwise().maxCoeff() - low;
  const double size = std::max(extent.maxCoeff(), 1e-9);
  MatrixX motions = MatrixX::Zero(places.size(), kBlock);
  for (Eigen::Index node = 0; node < places.cols(); ++node) {
    const Vector3 at = (places.col(node) - low) / size;
    for (int i = 0; i < 3; ++i) {
      motions(3 * node + i, i) = 1;
      for (int j = 0; j < 3; ++j) motions(3 * node + i, 3 + 3 * i + j) = at[j] + 0.2 * std::sin(1 + (4 + i) * at[(j + 1) % 3]);
    }
  }
  return motions;
}

// X is made a basis, orthonormal in M, of what it adds to the first `count` columns of V.
void orthonormalize(const VectorX& mass, const MatrixX& V, Eigen::Index count, MatrixX& X) {
  for (int pass = 0; pass < 2 && X.cols() > 0; ++pass) {
    if (count > 0) X -= V.leftCols(count) * (V.leftCols(count).transpose() * (mass.asDiagonal() * X));
    const MatrixX gram = X.transpose() * (mass.asDiagonal() * X);
    const Eigen::SelfAdjointEigenSolver<MatrixX> solver(gram);
    const VectorX& squares = solver.eigenvalues();
    const double least = kIndependent * squares.maxCoeff();
    const Eigen::Index kept = (squares.array() > least).count();
    X = (X * solver.eigenvectors().rightCols(kept) * squares.tail(kept).cwiseSqrt().cwiseInverse().asDiagonal()).eval();
  }
}

}  // namespace

LowModes find_low_modes(const SparseCholesky& factor, double scale, const VectorX& mass, const Matrix3X& places, int most) {
  const Eigen::Index unknowns = mass.size(), room = std::min<Eigen::Index>(unknowns, kVectorsPerMode * most);
  MatrixX V(unknowns, room), solved(unknowns, room), X = affine_motions(places), panel_rows = factor.make_panel_rows();
  Eigen::Index count = 0;
  while (count < room) {
    orthonormalize(mass, V, count, X);
    const Eigen::Index added = std::min(X.cols(), room - count);
    if (added == 0) break;
    V.middleCols(count, added) = X.leftCols(added);
    for (Eigen::Index k = count; k < count + added; ++k) {
      VectorX y = mass.cwiseProduct(V.col(k));
      factor.forward(y, panel_rows);
      factor.backward(y, panel_rows);
      solved.col(k) = y;
    }
    X = solved.middleCols(count, added);
    X.colwise().normalize();
    count += added;
  }
  MatrixX projected = V.leftCols(count).transpose() * (mass.asDiagonal() * solved.leftCols(count));
  projected = ((projected + projected.transpose()) / 2).eval();
  const Eigen::SelfAdjointEigenSolver<MatrixX> solver(projected);
  const Eigen::Index modes = std::min<Eigen::Index>(most, count);
  const MatrixX slowest = solver.eigenvectors().rightCols(modes).rowwise().reverse();
  return {(scale * solver.eigenvalues().tail(modes).reverse()).cwiseInverse(), (V.leftCols(count) * slowest).cast<float>()};
}

}  // namespace acus
