// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/math/factor/block_tridiagonal.h"

#include <cassert>

namespace acus {

void BlockTridiagonal::resize(int blocks) {
  assert(blocks > 0);
  const auto n = static_cast<std::size_t>(blocks);
  diagonal.assign(n, Matrix6::Zero());
  lower.assign(n - 1, Matrix6::Zero());
  pivot_inverse_ = diagonal;
  factor_lower_ = lower;
}

void BlockTridiagonal::set_zero() {
  for (Matrix6& block : diagonal) block.setZero();
  for (Matrix6& block : lower) block.setZero();
}

bool BlockTridiagonal::factorize() {
  for (std::size_t i = 0; i < diagonal.size(); ++i) {
    Matrix6 pivot = diagonal[i];
    if (i > 0) {
      factor_lower_[i - 1].noalias() = lower[i - 1] * pivot_inverse_[i - 1].transpose();
      pivot.noalias() -= factor_lower_[i - 1] * factor_lower_[i - 1].transpose();
    }
    const Eigen::LLT<Matrix6> cholesky(pivot);
    if (cholesky.info() != Eigen::Success || !pivot.allFinite()) return false;  // LLT lets not-a-numbers pass
    pivot_inverse_[i] = cholesky.matrixL().solve(Matrix6::Identity());
  }
  return true;
}

void BlockTridiagonal::forward(Eigen::Ref<VectorX> x) const {
  assert(x.size() == 6 * blocks());
  for (int i = 0; i < blocks(); ++i) {
    Vector6 rhs = x.segment<6>(6 * i);
    if (i > 0) rhs.noalias() -= factor_lower_[i - 1] * x.segment<6>(6 * (i - 1));
    x.segment<6>(6 * i).noalias() = pivot_inverse_[i] * rhs;
  }
}

void BlockTridiagonal::backward(Eigen::Ref<VectorX> x) const {
  assert(x.size() == 6 * blocks());
  for (int i = blocks() - 1; i >= 0; --i) {
    Vector6 rhs = x.segment<6>(6 * i);
    if (i + 1 < blocks()) rhs.noalias() -= factor_lower_[i].transpose() * x.segment<6>(6 * (i + 1));
    x.segment<6>(6 * i).noalias() = pivot_inverse_[i].transpose() * rhs;
  }
}

}  // namespace acus
