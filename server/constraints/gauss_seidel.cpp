// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/constraints/gauss_seidel.h"

#include <cmath>

namespace acus {

namespace {

using Vector2 = Eigen::Vector2d;

// An upper bound of the largest eigenvalue of the 2 x 2 block at row i.
double block_bound(const MatrixX& W, int i) {
  return std::max(W(i, i), W(i + 1, i + 1)) + std::abs(W(i, i + 1));
}

Vector2 disk_step(const MatrixX& W, std::span<const Law> laws, int i, std::span<const double> lambda,
                  std::span<const double> delta) {
  const double radius = laws[i].limit * std::max(lambda[laws[i].normal_row], 0.0);
  return disk_force(radius, block_bound(W, i), {lambda[i], lambda[i + 1]}, {delta[i], delta[i + 1]});
}

double row_step(const MatrixX& W, std::span<const Law> laws, int i, std::span<const double> lambda,
                std::span<const double> delta) {
  return law_force(laws[i], W(i, i), delta[i] - W(i, i) * lambda[i]);
}

// delta <- W lambda + delta_free
void evaluate(const MatrixX& W, std::span<const double> delta_free, std::span<const double> lambda,
              std::span<double> delta) {
  const auto n = static_cast<Eigen::Index>(lambda.size());
  Eigen::Map<VectorX> d(delta.data(), n);
  d = Eigen::Map<const VectorX>(delta_free.data(), n);
  for (Eigen::Index i = 0; i < n; ++i) d += lambda[i] * W.col(i).head(n);
}

// One sweep; delta is kept up to date with every move.
void sweep(const MatrixX& W, std::span<const Law> laws, std::span<double> lambda, std::span<double> delta) {
  const int n = static_cast<int>(laws.size());
  Eigen::Map<VectorX> d(delta.data(), n);
  const auto move = [&](int i, double force) {
    d += (force - lambda[i]) * W.col(i).head(n);
    lambda[i] = force;
  };
  for (int i = 0; i < n; ++i) {
    if (laws[i].kind == LawKind::disk_second) continue;
    if (laws[i].kind == LawKind::disk_first) {
      const Vector2 force = disk_step(W, laws, i, lambda, delta);
      move(i, force[0]);
      move(i + 1, force[1]);
    } else {
      move(i, row_step(W, laws, i, lambda, delta));
    }
  }
}

}  // namespace

double law_residual(const MatrixX& W, std::span<const Law> laws, std::span<const double> lambda,
                    std::span<const double> delta) {
  double largest = 0;
  for (int i = 0; i < static_cast<int>(laws.size()); ++i) {
    if (laws[i].kind == LawKind::disk_second) continue;
    const double violation =
        laws[i].kind == LawKind::disk_first
            ? (disk_step(W, laws, i, lambda, delta) - Vector2(lambda[i], lambda[i + 1])).norm()
            : std::abs(row_step(W, laws, i, lambda, delta) - lambda[i]);
    largest = std::max(largest, violation);
  }
  return largest;
}

GaussSeidel::GaussSeidel(int capacity) {
  const auto n = static_cast<std::size_t>(capacity);
  bilateral_.reserve(n);
  others_.reserve(n);
  laws_.reserve(n);
  place_.resize(n);
  lambda_.resize(n);
  delta_.resize(n);
  block_.setZero(capacity, capacity);
  coupling_.setZero(capacity, capacity);
  schur_.setZero(capacity, capacity);
  free_bilateral_.setZero(capacity);
  free_others_.setZero(capacity);
}

void GaussSeidel::split(std::span<const Law> laws) {
  bilateral_.clear();
  others_.clear();
  laws_.clear();
  for (int i = 0; i < static_cast<int>(laws.size()); ++i) {
    if (laws[i].kind == LawKind::bilateral) {
      bilateral_.push_back(i);
      continue;
    }
    place_[i] = static_cast<int>(others_.size());
    others_.push_back(i);
    laws_.push_back(laws[i]);
    if (laws[i].normal_row >= 0) laws_.back().normal_row = place_[laws[i].normal_row];
  }
}

void GaussSeidel::eliminate(const MatrixX& W, std::span<const Law> laws, std::span<const double> delta_free) {
  const auto b = static_cast<Eigen::Index>(bilateral_.size()), n = static_cast<Eigen::Index>(others_.size());
  auto block = block_.topLeftCorner(b, b);
  auto coupling = coupling_.topLeftCorner(b, n);
  auto schur = schur_.topLeftCorner(n, n);
  for (Eigen::Index i = 0; i < b; ++i) {
    for (Eigen::Index j = 0; j < b; ++j) block(i, j) = W(bilateral_[i], bilateral_[j]);
    for (Eigen::Index j = 0; j < n; ++j) coupling(i, j) = W(bilateral_[i], others_[j]);
    free_bilateral_[i] = delta_free[bilateral_[i]];
  }
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = 0; j < n; ++j) schur(i, j) = W(others_[i], others_[j]);
    free_others_[i] = delta_free[others_[i]];
  }
  if (b == 0) return;

  block.diagonal().array() += kRegularization * block.diagonal().mean();
  for (Eigen::Index i = 0; i < b; ++i) block(i, i) += laws[bilateral_[i]].softness * W(bilateral_[i], bilateral_[i]);
  Eigen::Ref<MatrixX> in_place(block);
  const Eigen::LLT<Eigen::Ref<MatrixX>> cholesky(in_place);
  const auto lower = block.triangularView<Eigen::Lower>();
  lower.solveInPlace(coupling);
  auto free_bilateral = free_bilateral_.head(b);
  lower.solveInPlace(free_bilateral);
  schur.noalias() -= coupling.transpose() * coupling;
  free_others_.head(n).noalias() -= coupling.transpose() * free_bilateral;
}

SolverResult GaussSeidel::solve(const MatrixX& W, std::span<const Law> laws, std::span<const double> delta_free,
                                int max_sweeps, double tolerance, std::span<double> lambda, std::span<double> delta) {
  split(laws);
  eliminate(W, laws, delta_free);
  const std::size_t n = others_.size();
  const std::span<double> lambda_others(lambda_.data(), n), delta_others(delta_.data(), n);
  const std::span<const double> free_others(free_others_.data(), n);
  for (std::size_t i = 0; i < n; ++i) lambda_others[i] = lambda[others_[i]];

  SolverResult result;
  evaluate(schur_, free_others, lambda_others, delta_others);
  while (result.sweeps < max_sweeps && law_residual(schur_, laws_, lambda_others, delta_others) > tolerance) {
    sweep(schur_, laws_, lambda_others, delta_others);
    ++result.sweeps;
  }

  for (std::size_t i = 0; i < n; ++i) lambda[others_[i]] = lambda_others[i];
  const auto b = static_cast<Eigen::Index>(bilateral_.size());
  auto force = free_bilateral_.head(b);
  force = -force;
  for (std::size_t i = 0; i < n; ++i) force -= lambda_others[i] * coupling_.col(static_cast<Eigen::Index>(i)).head(b);
  block_.topLeftCorner(b, b).triangularView<Eigen::Lower>().transpose().solveInPlace(force);
  for (Eigen::Index i = 0; i < b; ++i) lambda[bilateral_[i]] = force[i];

  evaluate(W, delta_free, lambda, delta);
  result.residual = law_residual(W, laws, lambda, delta);
  result.converged = result.residual <= tolerance;
  return result;
}

}  // namespace acus
