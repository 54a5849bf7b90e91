// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/laws/solver/pivoting.h"

#include <algorithm>
#include <cmath>

#include "server/engine/laws/contact_block.h"
#include "server/engine/math/partial_cholesky.h"

namespace acus {

namespace {

constexpr int kContactRows = 3;

}  // namespace

Pivoting::Pivoting(int capacity) {
  const auto n = static_cast<std::size_t>(capacity);
  pieces_.resize(n);
  rows_.reserve(n);
  matrix_.setZero(capacity, capacity);
  viscous_.setZero(capacity);
  rhs_.setZero(capacity);
  forces_.setZero(capacity);
  trial_lambda_.resize(n);
  trial_delta_.resize(n);
}

// The piece on which a force stands, or would if its row moved by `step` beyond the bounds; `lambda` is what rows keep
// that have no pieces.
Pivoting::Piece Pivoting::piece_at(const Law& law, double step, double lambda) {
  if (law.kind == LawKind::unilateral) {
    if (step <= 0) return {Piece::bound, 0};
    return step >= law.limit ? Piece{Piece::bound, law.limit} : Piece{Piece::rest, 0};
  }
  if (law.kind != LawKind::friction) return {Piece::bound, lambda};
  if (std::abs(step) <= law.limit) return {Piece::rest, 0};
  return {law.viscosity > 0 ? Piece::sliding : Piece::bound, std::copysign(law.limit, step)};
}

void Pivoting::start(const LawSystem& system, const LawState& state) {
  for (int i = 0; i < system.rows(); ++i) {
    if (!is_contact(system.laws, i)) {
      pieces_[i] = piece_at(system.laws[i], state.lambda[i] / kAtBound, state.lambda[i]);
      continue;
    }
    for (int k = 0; k < kContactRows; ++k) pieces_[i + k] = {Piece::contact, 0};
    i += kContactRows - 1;
  }
}

// Every row whose law is violated picks its piece anew; returns how many changed.
int Pivoting::pick_anew(const LawSystem& system, const LawState& state) {
  const double slack = kPickAbove * force_scale(state.lambda);
  int changed = 0;
  for (int i = 0; i < system.rows(); ++i) {
    if (pieces_[i].kind == Piece::contact || !(law_violation(system, i, state) > slack)) continue;
    const double step = state.lambda[i] - state.delta[i] / system.scale[i];  // where the row's own line leads
    const Piece picked = piece_at(system.laws[i], step, state.lambda[i]);
    if (picked == pieces_[i]) continue;
    pieces_[i] = picked;
    ++changed;
  }
  return changed;
}

void Pivoting::number_rows(int rows) {
  rows_.clear();
  for (int i = 0; i < rows; ++i)
    if (pieces_[i].on_line()) rows_.push_back(i);
  lines_ = static_cast<Eigen::Index>(rows_.size());
  for (int i = 0; i < rows; ++i)
    if (pieces_[i].kind == Piece::contact) rows_.push_back(i);
}

// matrix_ forces_ = rhs_ on lines, matrix_ forces_ + rhs_ = displacements of contacts, with the others at their bounds.
void Pivoting::fill(const LawSystem& system, const LawState& state) {
  const auto n = static_cast<Eigen::Index>(rows_.size());
  gather_lower(system.W, rows_, matrix_.topLeftCorner(n, n));
  for (Eigen::Index a = 0; a < n; ++a) forces_[a] = state.lambda[rows_[a]];  // where contacts start from

  for (int i = 0; i < system.rows(); ++i) state.lambda[i] = pieces_[i].kind == Piece::bound ? pieces_[i].force : 0;
  update_displacements(system, state);
  for (Eigen::Index a = 0; a < n; ++a) rhs_[a] = state.delta[rows_[a]];
  if (lines_ == 0) return;
  const double regularization = kRegularization * matrix_.diagonal().head(lines_).mean();
  for (Eigen::Index a = 0; a < lines_; ++a) {
    const Piece& piece = pieces_[rows_[a]];
    viscous_[a] = piece.kind == Piece::sliding ? 1 / system.laws[rows_[a]].viscosity : 0;
    rhs_[a] = viscous_[a] * piece.force - rhs_[a];
    matrix_(a, a) += viscous_[a] + regularization;
  }
}

// The exact forces of each contact on its own block of K, in turn until none moves. rhs_ are the displacements that are
// left at zero force of all contacts.
void Pivoting::solve_contacts(const LawSystem& system) {
  const Eigen::Index count = static_cast<Eigen::Index>(rows_.size()) - lines_;
  auto K = matrix_.block(lines_, lines_, count, count);
  K.triangularView<Eigen::StrictlyUpper>() = K.transpose();
  auto all = forces_.segment(lines_, count);
  bool moved = true;
  for (int round = 0; round < kMaxContactRounds && moved; ++round) {
    moved = false;
    for (Eigen::Index c = 0; c < count; c += kContactRows) {
      const int row = rows_[lines_ + c];
      const Law &normal = system.laws[row], &friction = system.laws[row + 1];
      const Matrix3 block = K.block<kContactRows, kContactRows>(c, c);
      auto own = all.segment<kContactRows>(c);
      const Vector3 bar =
          rhs_.segment<kContactRows>(lines_ + c) + K.middleRows<kContactRows>(c).lazyProduct(all) - block * own;
      const Vector3 force = contact_force({normal.limit, friction.limit, friction.cohesion}, block, bar);
      moved = moved || (force - own).norm() > kContactsEnd * std::max(1.0, force.norm());
      own = force;
    }
    if (count == kContactRows) return;
  }
}

// One step of refinement for the regularisation of the rows on lines, contacts held.
void Pivoting::refine(const LawSystem& system, const LawState& state) {
  auto step = rhs_.head(lines_);
  for (Eigen::Index a = 0; a < lines_; ++a) {
    const int i = rows_[a];
    step[a] = viscous_[a] * (pieces_[i].force - state.lambda[i]) - state.delta[i];
  }
  cholesky_solve(matrix_.topLeftCorner(lines_, lines_), step);
  for (Eigen::Index a = 0; a < lines_; ++a) state.lambda[rows_[a]] += step[a];
  update_displacements(system, state);
}

// The forces with every row on its piece; false if the system of the rows on lines is not positive definite.
bool Pivoting::move(const LawSystem& system, const LawState& state) {
  number_rows(system.rows());
  fill(system, state);
  const auto n = static_cast<Eigen::Index>(rows_.size()), contacts = n - lines_;
  if (!partial_cholesky(matrix_.topLeftCorner(n, n), lines_)) return false;
  const auto factor = matrix_.topLeftCorner(lines_, lines_);
  const auto coupling = matrix_.block(lines_, 0, contacts, lines_);
  auto lines = rhs_.head(lines_);
  factor.triangularView<Eigen::Lower>().solveInPlace(lines);
  rhs_.segment(lines_, contacts) += coupling.lazyProduct(lines);
  solve_contacts(system);
  lines -= coupling.transpose().lazyProduct(forces_.segment(lines_, contacts));
  factor.transpose().triangularView<Eigen::Upper>().solveInPlace(lines);
  forces_.head(lines_) = lines;
  for (Eigen::Index a = 0; a < n; ++a) state.lambda[rows_[a]] = forces_[a];
  update_displacements(system, state);
  refine(system, state);
  return true;
}

int Pivoting::solve(const LawSystem& system, const LawState& state, StepBudget& budget) {
  const auto n = static_cast<std::size_t>(system.rows());
  const LawState trial{{trial_lambda_.data(), n}, {trial_delta_.data(), n}};
  update_displacements(system, state);
  copy(state, trial);
  double best = law_residual(system, state);
  start(system, state);
  int picks = 0, fewest = system.rows() + 1, patience = kPatience;
  for (int changed = system.rows(); changed > 0 && patience > 0 && picks < kMaxPicks && budget.take(); ++picks) {
    if (!move(system, trial)) break;
    const double residual = law_residual(system, trial);
    if (residual < best) {
      best = residual;
      copy(trial, state);
    }
    changed = pick_anew(system, trial);
    if (changed < fewest) {
      fewest = changed;
      patience = kPatience;
    } else {
      --patience;
    }
  }
  return picks;
}

}  // namespace acus
