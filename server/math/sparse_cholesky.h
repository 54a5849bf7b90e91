// SPDX-License-Identifier: GPL-3.0-or-later
// Sparse Cholesky factorisation P A Pᵀ = L Lᵀ by CHOLMOD's supernodal code, with our own substitutions on its factor:
// they can be called one at a time, start at any column, allocate nothing and give the same bits every time.
// Vectors handed to forward() and backward() are in the permuted order, unknown i at position(i).
//
// A supernode is a run of columns of L with the same rows below the diagonal, stored as one dense panel
// (Chen, Davis, Hager, Rajamanickam 2008, "Algorithm 887: CHOLMOD").
#pragma once

#include <Eigen/Sparse>
#include <memory>
#include <stdexcept>
#include <vector>

#include "server/math/types.h"

namespace acus {

using SparseMatrix = Eigen::SparseMatrix<double>;

class SparseCholesky {
 public:
  SparseCholesky();
  ~SparseCholesky();
  SparseCholesky(SparseCholesky&&) noexcept;
  SparseCholesky& operator=(SparseCholesky&&) noexcept;

  // Orders and analyses the pattern of the symmetric matrix whose lower triangle is given. Throws std::runtime_error
  // when memory runs out.
  void analyze(const SparseMatrix& lower_triangle);

  // Numeric factorisation of a matrix with the analysed pattern; false if it is not positive definite.
  bool factorize(const SparseMatrix& lower_triangle);

  int size() const;
  std::size_t factor_entries() const;  // stored entries of L, padding of the panels included

  // position(i): where unknown i stands in the permuted order.
  int position(int unknown) const { return position_[static_cast<std::size_t>(unknown)]; }

  // x <- L⁻¹ x. Entries before `first` must be zero; columns they would start are skipped.
  void forward(Eigen::Ref<VectorX> x, int first = 0) const;
  // The same for three right-hand sides at once, as columns.
  void forward3(Eigen::Ref<Eigen::MatrixX3d> x, int first = 0) const;
  // x <- L⁻ᵀ x.
  void backward(Eigen::Ref<VectorX> x) const;

 private:
  struct Factor;
  std::unique_ptr<Factor> factor_;
  std::vector<int> position_;
  mutable VectorX gathered_;  // scratch: entries below one panel
};

}  // namespace acus
