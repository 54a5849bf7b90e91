// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/laws/solver/reduced_laws.h"

#include <utility>

#include "server/engine/math/factor/partial_cholesky.h"

namespace acus {

ReducedLaws::ReducedLaws(int capacity, std::span<double> room) : room_(room) {
  const auto n = static_cast<std::size_t>(capacity);
  order_.reserve(n);
  others_.reserve(n);
  place_.resize(n);
  laws_.reserve(n);
  scale_.resize(n);
  lambda_.resize(n);
  delta_.resize(n);
  softness_.setZero(capacity);
  y_.setZero(capacity);
  delta_free_.setZero(capacity);
  step_.setZero(capacity);
}

void ReducedLaws::split(const LawSystem& full) {
  order_.clear();
  others_.clear();
  laws_.clear();
  for (int i = 0; i < full.rows(); ++i) {
    const Law& law = full.laws[i];
    if (law.kind == LawKind::bilateral) {
      softness_[static_cast<Eigen::Index>(order_.size())] = law.compliance;
      order_.push_back(i);
      continue;
    }
    place_[i] = static_cast<int>(others_.size());
    scale_[others_.size()] = full.scale[i];
    others_.push_back(i);
    laws_.push_back(law);
    if (law.normal_row >= 0) laws_.back().normal_row = place_[law.normal_row];
  }
  bilateral_count_ = static_cast<Eigen::Index>(order_.size());
  other_count_ = static_cast<Eigen::Index>(others_.size());
  order_.insert(order_.end(), others_.begin(), others_.end());
}

bool ReducedLaws::factorize(const LawSystem& full) {
  auto matrix = factor();
  if (bilateral_count_ == 0) {
    gather_lower(full.W, order_, matrix);
    return true;
  }
  const auto softness = softness_.head(bilateral_count_);
  auto diagonal = matrix.diagonal().head(bilateral_count_);
  for (double share = kRegularization; share <= 1; share *= 100) {
    gather_lower(full.W, order_, matrix);
    diagonal.array() += share * diagonal.mean();  // of W itself: soft rows must not count
    diagonal += softness;
    if (partial_cholesky(matrix, bilateral_count_)) return true;
  }
  return false;
}

bool ReducedLaws::reduce(const LawSystem& full) {
  split(full);
  if (!factorize(full)) return false;
  auto schur = factor().bottomRightCorner(other_count_, other_count_);
  mirror_lower(schur);
  return schur.allFinite();
}

void ReducedLaws::linearize(const LawState& iterate) {
  const auto matrix = std::as_const(*this).factor();
  const auto coupling = matrix.bottomLeftCorner(other_count_, bilateral_count_);
  const auto schur = matrix.bottomRightCorner(other_count_, other_count_);
  auto y = y_.head(bilateral_count_);
  auto bar = delta_free_.head(other_count_);
  for (Eigen::Index i = 0; i < bilateral_count_; ++i)
    y[i] = iterate.delta[order_[i]] + softness_[i] * iterate.lambda[order_[i]];
  matrix.topLeftCorner(bilateral_count_, bilateral_count_).triangularView<Eigen::Lower>().solveInPlace(y);
  for (Eigen::Index i = 0; i < other_count_; ++i) bar[i] = iterate.delta[others_[i]];
  for (Eigen::Index j = 0; j < bilateral_count_; ++j) bar -= y[j] * coupling.col(j);
  for (Eigen::Index j = 0; j < other_count_; ++j) {
    const double force = iterate.lambda[others_[j]];
    step_[j] = force;
    if (force != 0) bar -= force * schur.col(j);
  }
}

LawSystem ReducedLaws::system() const {
  return {factor().bottomRightCorner(other_count_, other_count_),
          laws_,
          {delta_free_.data(), others_.size()},
          {scale_.data(), others_.size()}};
}

void ReducedLaws::gather(std::span<const double> lambda) {
  for (std::size_t i = 0; i < others_.size(); ++i) lambda_[i] = lambda[others_[i]];
}

void ReducedLaws::expand(std::span<double> lambda) {
  const auto matrix = std::as_const(*this).factor();
  auto y = y_.head(bilateral_count_);
  auto change = step_.head(other_count_);
  for (Eigen::Index i = 0; i < other_count_; ++i) {
    change[i] = lambda_[i] - change[i];
    lambda[others_[i]] = lambda_[i];
  }
  y.noalias() += matrix.bottomLeftCorner(other_count_, bilateral_count_).transpose().lazyProduct(change);
  const auto corner = matrix.topLeftCorner(bilateral_count_, bilateral_count_);
  corner.transpose().triangularView<Eigen::Upper>().solveInPlace(y);
  for (Eigen::Index i = 0; i < bilateral_count_; ++i) lambda[order_[i]] -= y[i];
}

}  // namespace acus
