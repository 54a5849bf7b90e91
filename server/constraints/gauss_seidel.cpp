// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/constraints/gauss_seidel.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "server/constraints/contact_block.h"

namespace acus {

namespace {

using Vector2 = Eigen::Vector2d;

// An upper bound of the largest eigenvalue of the 2 x 2 block at row i.
double block_bound(const MatrixX& W, int i) {
  return std::max(W(i, i), W(i + 1, i + 1)) + std::abs(W(i, i + 1));
}

Vector2 disk_step(const MatrixX& W, std::span<const Law> laws, int i, std::span<const double> lambda,
                  std::span<const double> delta) {
  const double radius = laws[i].cohesion + laws[i].limit * std::max(lambda[laws[i].normal_row], 0.0);
  return disk_force(radius, block_bound(W, i), {lambda[i], lambda[i + 1]}, {delta[i], delta[i + 1]});
}

double row_step(const MatrixX& W, std::span<const Law> laws, int i, std::span<const double> lambda,
                std::span<const double> delta) {
  return law_force(laws[i], W(i, i), delta[i] - W(i, i) * lambda[i]);
}

// A normal row with its two rows of friction right behind it.
bool is_contact(std::span<const Law> laws, std::size_t i) {
  return i + 2 < laws.size() && laws[i + 1].kind == LawKind::disk_first &&
         laws[i + 1].normal_row == static_cast<int>(i);
}

Vector3 contact_step(const MatrixX& W, std::span<const Law> laws, int i, std::span<const double> lambda,
                     std::span<const double> delta) {
  const Matrix3 block = W.block<3, 3>(i, i);
  const Vector3 now(lambda[i], lambda[i + 1], lambda[i + 2]), at(delta[i], delta[i + 1], delta[i + 2]);
  return contact_force({laws[i].limit, laws[i + 1].limit, laws[i + 1].cohesion}, block, at - block * now);
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
    if (is_contact(laws, static_cast<std::size_t>(i))) {
      const Vector3 force = contact_step(W, laws, i, lambda, delta);
      for (int k = 0; k < 3; ++k) move(i + k, force[k]);
      i += 2;
    } else if (laws[i].kind == LawKind::disk_first) {
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
    if (!(violation <= largest)) largest = violation;  // not-a-number is the largest of all
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
  softening_.setZero(capacity);
  diagonal_.setZero(capacity);
  straight_.reserve(n);
  subspace_.setZero(capacity, capacity);
  subspace_rhs_.setZero(capacity);
  pieces_.resize(n);
  picked_.resize(n);
  trial_lambda_.resize(n);
  trial_delta_.resize(n);
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

// In place, with as little regularisation as it takes; the strict upper triangle keeps a copy of W_BB for another try.
void GaussSeidel::factorize_bilateral() {
  const auto b = static_cast<Eigen::Index>(bilateral_.size());
  auto block = block_.topLeftCorner(b, b);
  const auto diagonal = diagonal_.head(b);
  const double mean = (diagonal - softening_.head(b)).mean();  // of W_BB itself: a soft row must not spoil the others
  for (double share = kRegularization; share < 1; share *= 100) {
    for (Eigen::Index i = 0; i < b; ++i) {
      for (Eigen::Index j = 0; j < i; ++j) block(i, j) = block(j, i);
      block(i, i) = diagonal[i] + share * mean;
    }
    Eigen::Ref<MatrixX> in_place(block);
    if (Eigen::LLT<Eigen::Ref<MatrixX>>(in_place).info() == Eigen::Success) return;
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

  for (Eigen::Index i = 0; i < b; ++i) {
    softening_[i] = laws[bilateral_[i]].compliance;
    diagonal_[i] = block(i, i) + softening_[i];
  }
  factorize_bilateral();
  const auto lower = block.triangularView<Eigen::Lower>();
  lower.solveInPlace(coupling);
  auto free_bilateral = free_bilateral_.head(b);
  lower.solveInPlace(free_bilateral);
  schur.noalias() -= coupling.transpose() * coupling;
  free_others_.head(n).noalias() -= coupling.transpose() * free_bilateral;
}

// The piece of its graph that a row's law picks at (lambda, delta): a straight one, where a linear equation holds, or a
// bound, where the force is known. By the law's own step, which is at rest on the right piece.
GaussSeidel::Piece GaussSeidel::piece_of(int i, double lambda, double delta) const {
  const Law& law = laws_[i];
  const double step = lambda - delta / schur_(i, i);
  if (law.kind == LawKind::unilateral) {
    if (step <= 0) return {false, 0};
    return step >= law.limit ? Piece{false, law.limit} : Piece{true, 0};
  }
  if (law.kind != LawKind::friction) return {false, lambda};
  if (std::abs(step) <= law.limit) return {true, 0};
  return {law.viscosity > 0, std::copysign(law.limit, step)};
}

// Solves S lambda + delta_bar = 0 on the rows that stick, S lambda + delta_bar = (T - lambda)/c on those that slide with
// viscosity c, T their threshold with its sign, with the others at their bounds.
bool GaussSeidel::solve_straight(std::span<double> lambda) {
  straight_.clear();
  for (int i = 0; i < static_cast<int>(laws_.size()); ++i) {
    if (pieces_[i].straight) straight_.push_back(i);
    else lambda[i] = pieces_[i].force;
  }
  const auto m = static_cast<Eigen::Index>(straight_.size());
  if (m == 0) return true;
  auto system = subspace_.topLeftCorner(m, m);
  auto rhs = subspace_rhs_.head(m);
  double mean = 0;  // of S
  for (const int i : straight_) mean += schur_(i, i) / static_cast<double>(m);
  for (Eigen::Index a = 0; a < m; ++a) {
    const int i = straight_[a];
    rhs[a] = -free_others_[i];
    for (int j = 0; j < static_cast<int>(laws_.size()); ++j)
      if (!pieces_[j].straight) rhs[a] -= schur_(i, j) * lambda[j];
    for (Eigen::Index b = 0; b < m; ++b) system(a, b) = schur_(i, straight_[b]);
    system(a, a) += kSubspaceRegularization * mean;
    if (pieces_[i].force == 0) continue;
    system(a, a) += 1 / laws_[i].viscosity;
    rhs[a] += pieces_[i].force / laws_[i].viscosity;
  }
  Eigen::Ref<MatrixX> in_place(system);
  const Eigen::LLT<Eigen::Ref<MatrixX>> cholesky(in_place);
  if (cholesky.info() != Eigen::Success) return false;
  system.triangularView<Eigen::Lower>().solveInPlace(rhs);
  system.triangularView<Eigen::Lower>().transpose().solveInPlace(rhs);
  for (Eigen::Index a = 0; a < m; ++a) lambda[straight_[a]] = rhs[a];
  return true;
}

// Every row picks its piece anew at (lambda, delta). While that makes the picks that change fewer all of them are taken
// over; when it has not done so for a while, only the last one, which cannot go round in circles.
bool GaussSeidel::pick_pieces(std::span<const double> lambda, std::span<const double> delta, Picks& picks) {
  int changed = 0, last = -1;
  for (int i = 0; i < static_cast<int>(laws_.size()); ++i) {
    picked_[i] = piece_of(i, lambda[i], delta[i]);
    if (picked_[i] == pieces_[i]) continue;
    ++changed;
    last = i;
  }
  if (changed == 0) return false;
  if (changed < picks.fewest) {
    picks = {changed, kPatience};
  } else if (picks.patience > 0) {
    --picks.patience;
  } else {
    // From one bound to the other by way of what lies between.
    const bool between = !pieces_[last].straight && !picked_[last].straight;
    pieces_[last] = between ? Piece{true, 0} : picked_[last];
    return true;
  }
  std::copy(picked_.begin(), picked_.begin() + static_cast<std::ptrdiff_t>(laws_.size()), pieces_.begin());
  return true;
}

// Newton on the pieces: solve, let the rows pick, and again, until the picks repeat. Keeps the best.
void GaussSeidel::subspace_step(std::span<double> lambda, std::span<double> delta) {
  const std::size_t n = lambda.size();
  const std::span<double> trial(trial_lambda_.data(), n), trial_delta(trial_delta_.data(), n);
  const std::span<const double> free_others(free_others_.data(), n);
  std::copy(lambda.begin(), lambda.end(), trial.begin());
  std::copy(delta.begin(), delta.end(), trial_delta.begin());
  double best = law_residual(schur_, laws_, lambda, delta);
  Picks picks{static_cast<int>(n) + 1, kPatience};
  for (std::size_t i = 0; i < n; ++i) pieces_[i] = piece_of(static_cast<int>(i), lambda[i], delta[i]);
  for (int k = 0; k < kMaxPicks; ++k) {
    if (k > 0 && !pick_pieces(trial, trial_delta, picks)) return;
    if (!solve_straight(trial)) return;
    evaluate(schur_, free_others, trial, trial_delta);
    const double residual = law_residual(schur_, laws_, trial, trial_delta);
    if (!(residual < best)) continue;
    best = residual;
    std::copy(trial.begin(), trial.end(), lambda.begin());
    std::copy(trial_delta.begin(), trial_delta.end(), delta.begin());
  }
}

// lambda_B from the others, with one step of refinement for what the regularisation left over.
void GaussSeidel::solve_bilateral(std::span<const double> lambda_others, const MatrixX& W,
                                  std::span<const double> delta_free, std::span<double> lambda,
                                  std::span<double> delta) {
  const auto b = static_cast<Eigen::Index>(bilateral_.size());
  const auto upper = block_.topLeftCorner(b, b).triangularView<Eigen::Lower>().transpose();
  const auto lower = block_.topLeftCorner(b, b).triangularView<Eigen::Lower>();
  auto force = free_bilateral_.head(b);
  force = -force;
  for (std::size_t i = 0; i < lambda_others.size(); ++i)
    force -= lambda_others[i] * coupling_.col(static_cast<Eigen::Index>(i)).head(b);
  upper.solveInPlace(force);
  for (Eigen::Index i = 0; i < b; ++i) lambda[bilateral_[i]] = force[i];

  evaluate(W, delta_free, lambda, delta);
  for (Eigen::Index i = 0; i < b; ++i) force[i] = -delta[bilateral_[i]] - softening_[i] * lambda[bilateral_[i]];
  lower.solveInPlace(force);
  upper.solveInPlace(force);
  for (Eigen::Index i = 0; i < b; ++i) lambda[bilateral_[i]] += force[i];
  evaluate(W, delta_free, lambda, delta);
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
  // Half the tolerance, as the residual that counts is taken on the full W at the end.
  while (result.sweeps < max_sweeps && law_residual(schur_, laws_, lambda_others, delta_others) > tolerance / 2) {
    sweep(schur_, laws_, lambda_others, delta_others);
    if (++result.sweeps % kSubspaceInterval != 0) continue;
    if (std::has_single_bit(static_cast<unsigned>(result.sweeps))) subspace_step(lambda_others, delta_others);
    evaluate(schur_, free_others, lambda_others, delta_others);  // rounding errors of the sweeps' running sums
  }
  for (std::size_t i = 0; i < n; ++i) lambda[others_[i]] = lambda_others[i];
  solve_bilateral(lambda_others, W, delta_free, lambda, delta);
  result.residual = law_residual(W, laws, lambda, delta);
  result.converged = result.residual <= tolerance;
  return result;
}

}  // namespace acus
