// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/laws/solver/pivoting.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "server/engine/laws/contact_block.h"
#include "server/engine/math/partial_cholesky.h"

namespace acus {

namespace {

constexpr int kContactRows = 3;

}  // namespace

Pivoting::Pivoting(int capacity, VectorX& room) : room_(room) {
  const auto n = static_cast<std::size_t>(capacity);
  pieces_.resize(n);
  picks_.reserve(n);
  rows_.reserve(n);
  assert(room.size() >= static_cast<Eigen::Index>(capacity) * capacity);
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

// Of every row whose law is violated.
void Pivoting::find_picks(const LawSystem& system, const LawState& state) {
  const double slack = kPickAbove * force_scale(state.lambda);
  picks_.clear();
  for (int i = 0; i < system.rows(); ++i) {
    if (pieces_[i].kind == Piece::contact) continue;
    const double violation = law_violation(system, i, state);
    if (!(violation > slack)) continue;
    const double step = state.lambda[i] - state.delta[i] / system.scale[i];  // where the row's own line leads
    const Piece picked = piece_at(system.laws[i], step, state.lambda[i]);
    if (!(picked == pieces_[i])) picks_.push_back({i, picked, violation});
  }
}

void Pivoting::number_rows(int rows) {
  rows_.clear();
  for (int i = 0; i < rows; ++i)
    if (pieces_[i].on_line()) rows_.push_back(i);
  lines_ = static_cast<Eigen::Index>(rows_.size());
  for (int i = 0; i < rows; ++i)
    if (pieces_[i].kind == Piece::contact) rows_.push_back(i);
}

// matrix() forces_ = rhs_ on lines, matrix() forces_ + rhs_ = displacements of contacts, with the others at their
// bounds.
void Pivoting::fill(const LawSystem& system, const LawState& state) {
  const auto n = static_cast<Eigen::Index>(rows_.size());
  auto matrix = this->matrix();
  gather_lower(system.W, rows_, matrix);
  for (Eigen::Index a = 0; a < n; ++a) forces_[a] = state.lambda[rows_[a]];  // where contacts start from

  for (int i = 0; i < system.rows(); ++i) state.lambda[i] = pieces_[i].kind == Piece::bound ? pieces_[i].force : 0;
  update_displacements(system, state);
  for (Eigen::Index a = 0; a < n; ++a) rhs_[a] = state.delta[rows_[a]];
  if (lines_ == 0) return;
  const double regularization = kRegularization * matrix.diagonal().head(lines_).mean();
  for (Eigen::Index a = 0; a < lines_; ++a) {
    const Piece& piece = pieces_[rows_[a]];
    viscous_[a] = piece.kind == Piece::sliding ? 1 / system.laws[rows_[a]].viscosity : 0;
    rhs_[a] = viscous_[a] * piece.force - rhs_[a];
    matrix(a, a) += viscous_[a] + regularization;
  }
}

// The exact forces of each contact on its own block of K, in turn until none moves. rhs_ are the displacements that are
// left at zero force of all contacts.
void Pivoting::solve_contacts(const LawSystem& system) {
  const Eigen::Index count = static_cast<Eigen::Index>(rows_.size()) - lines_;
  auto K = matrix().block(lines_, lines_, count, count);
  mirror_lower(K);
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
  cholesky_solve(matrix().topLeftCorner(lines_, lines_), step);
  for (Eigen::Index a = 0; a < lines_; ++a) state.lambda[rows_[a]] += step[a];
  update_displacements(system, state);
}

// The forces with every row on its piece; false if the system of the rows on lines is not positive definite.
bool Pivoting::move(const LawSystem& system, const LawState& state) {
  number_rows(system.rows());
  fill(system, state);
  const auto n = static_cast<Eigen::Index>(rows_.size()), contacts = n - lines_;
  auto matrix = this->matrix();
  if (!partial_cholesky(matrix, lines_)) return false;
  const auto factor = matrix.topLeftCorner(lines_, lines_);
  const auto coupling = matrix.block(lines_, 0, contacts, lines_);
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
  bool one_by_one = false;
  std::size_t fewest = n + 1;
  int picks = 0;
  while (picks < kMaxPicks && budget.take() && move(system, trial)) {
    ++picks;
    const double residual = law_residual(system, trial);
    if (residual < best) {
      best = residual;
      copy(trial, state);
    }
    find_picks(system, trial);
    if (picks_.empty()) break;
    one_by_one = one_by_one || picks_.size() >= fewest;
    fewest = picks_.size();
    if (one_by_one) {
      const Pick& worst = *std::ranges::max_element(picks_, {}, &Pick::violation);
      pieces_[worst.row] = worst.piece;
    } else {
      for (const Pick& pick : picks_) pieces_[pick.row] = pick.piece;
    }
  }
  return picks;
}

}  // namespace acus
