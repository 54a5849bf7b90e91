// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/support/dense.h"

#include <doctest/doctest.h>

#include <cassert>

namespace acus::test {

MatrixX solve_dense(const MatrixX& a, const MatrixX& b) {
  assert(a.rows() == a.cols() && a.rows() == b.rows());
  if (b.cols() == 0) return b;  // of which Eigen 3.4 would take an element's address
  return a.partialPivLu().solve(b);
}

MatrixX inverse(const MatrixX& a) {
  assert(a.rows() == a.cols());
  return a.inverse();
}

VectorX eigenvalues(const MatrixX& a) {
  assert(a.rows() == a.cols());
  return Eigen::SelfAdjointEigenSolver<MatrixX>(a, Eigen::EigenvaluesOnly).eigenvalues();
}

MatrixX cholesky_factor(const MatrixX& a) {
  assert(a.rows() == a.cols());
  const Eigen::LLT<MatrixX> factor(a);
  REQUIRE(factor.info() == Eigen::Success);
  return factor.matrixL();
}

MatrixX orthogonal_factor(const MatrixX& a) {
  assert(a.rows() == a.cols());
  return Eigen::HouseholderQR<MatrixX>(a).householderQ();
}

Polar polar_decomposition(const Matrix3& f) {
  const Eigen::JacobiSVD<Matrix3> svd(f, Eigen::ComputeFullU | Eigen::ComputeFullV);
  return {svd.matrixU() * svd.matrixV().transpose(), svd.singularValues()};
}

}  // namespace acus::test
