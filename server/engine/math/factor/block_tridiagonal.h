// SPDX-License-Identifier: GPL-3.0-or-later
// Cholesky factorisation of a symmetric positive definite block-tridiagonal matrix of 6 x 6 blocks, A = L Lᵀ:
//
//   A = | D_0 E_0ᵀ          |      L = | C_0            |      C_i C_iᵀ = D_i - F_i F_iᵀ
//       | E_0 D_1  E_1ᵀ     |          | F_1 C_1        |      F_{i+1}  = E_i C_i⁻ᵀ
//       |     E_1  D_2  ... |          |     F_2 C_2 ...|
//
// Cost: O(blocks). Nothing allocates after resize().
#pragma once

#include <vector>

#include "server/engine/math/types.h"

namespace acus {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

class BlockTridiagonal {
 public:
  void resize(int blocks);
  int blocks() const { return static_cast<int>(diagonal.size()); }
  void set_zero();

  // Factorises; false, with no usable factor, if a pivot is not positive.
  bool factorize();

  // x <- L⁻¹ x and x <- L⁻ᵀ x, for x of 6 * blocks() entries.
  void forward(Eigen::Ref<VectorX> x) const;
  void backward(Eigen::Ref<VectorX> x) const;

  // Of the inverse Z = A⁻¹: above the diagonal its blocks follow from those below them in their column, and
  // Z_ij = G_i Z_i+1,j for j > i, Z_ii = C_i⁻ᵀ C_i⁻¹ + G_i Z_i+1,i, with G_i = -C_i⁻ᵀ F_i+1ᵀ.
  Matrix6 transfer(int i) const { return -(factor_lower_[i] * pivot_inverse_[i]).transpose(); }
  Matrix6 pivot_inverse(int i) const { return pivot_inverse_[i].transpose() * pivot_inverse_[i]; }

  std::vector<Matrix6> diagonal;  // D_i
  std::vector<Matrix6> lower;     // E_i, row block i + 1, column block i

 private:
  std::vector<Matrix6> pivot_inverse_;  // C_i⁻¹, lower triangular
  std::vector<Matrix6> factor_lower_;   // F_{i+1}
};

}  // namespace acus
