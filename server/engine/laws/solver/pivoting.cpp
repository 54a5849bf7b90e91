// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/laws/solver/pivoting.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "server/engine/laws/contact_block.h"
#include "server/engine/math/factor/partial_cholesky.h"

namespace acus {

namespace {

constexpr int kContactRows = 3;

}  // namespace

Pivoting::Pivoting(int capacity, const std::span<double>& room) : room_(room) {
  const auto n = static_cast<std::size_t>(capacity);
  pieces_.resize(n);
  picks_.reserve(n);
  rows_.reserve(n);
  tangents_.resize(n);
  give_.setZero(capacity);
  coupled_.setZero(capacity);
  offset_.setZero(capacity);
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
  if (law.limit > 0 && std::abs(step) <= law.limit) return {Piece::rest, 0};
  return {law.viscosity > 0 ? Piece::sliding : Piece::bound, std::copysign(law.limit, step)};
}

double Pivoting::start(const LawSystem& system, const LawState& state) {
  double largest = 0;
  for (int i = 0; i < system.rows(); ++i) {
    double violation = 0;
    if (const int rows = cone_rows(system.laws, i)) {
      const DiskContact answer = cone_answer(system, i, state);
      violation = distance(system, i, state, answer);
      tangents_[i] = cone_tangent(*system.laws[i].cone, answer, system.scale[i]);
      put_piece(system, {i, {answer.slips ? Piece::slipping : Piece::rest, 0}, 0});
      i += rows - 1;
    } else if (is_contact(system.laws, i)) {
      violation = std::max(law_violation(system, i, state), law_violation(system, i + 1, state));
      for (int k = 0; k < kContactRows; ++k) pieces_[i + k] = {Piece::contact, 0};
      i += kContactRows - 1;
    } else {
      violation = law_violation(system, i, state);
      pieces_[i] = piece_at(system.laws[i], state.lambda[i] / kAtBound, state.lambda[i]);
    }
    if (!(violation <= largest)) largest = violation;
    if (std::isnan(largest)) break;
  }
  return largest;
}

void Pivoting::put_piece(const LawSystem& system, const Pick& pick) {
  const int rows = std::max(1, cone_rows(system.laws, pick.row));
  for (int k = 0; k < rows; ++k) pieces_[pick.row + k] = pick.piece;
}

double Pivoting::look(const LawSystem& system, const LawState& state) {
  const double slack = kPickAbove * force_scale(state.lambda);
  double largest = 0;
  picks_.clear();
  for (int i = 0; i < system.rows(); ++i) {
    const int rows = cone_rows(system.laws, i);
    const double violation = rows > 0 ? look_at_cone(system, i, state, slack) : law_violation(system, i, state);
    if (!(violation <= largest)) largest = violation;
    if (std::isnan(largest)) break;
    if (rows > 0) i += rows - 1;
    if (rows > 0 || pieces_[i].kind == Piece::contact || violation <= slack) continue;
    const double step = state.lambda[i] - state.delta[i] / system.scale[i];  // where the row's own line leads
    const Piece picked = piece_at(system.laws[i], step, state.lambda[i]);
    if (!(picked == pieces_[i])) picks_.push_back({i, picked, violation});
  }
  return largest;
}

// Returns its violation (N).
double Pivoting::look_at_cone(const LawSystem& system, int i, const LawState& state, double slack) {
  const DiskContact answer = cone_answer(system, i, state);
  const double violation = distance(system, i, state, answer);
  if (!(violation > slack)) return violation;
  if (answer.slips) tangents_[i] = cone_tangent(*system.laws[i].cone, answer, system.scale[i]);
  const Piece picked{answer.slips ? Piece::slipping : Piece::rest, 0};
  if (!(picked == pieces_[i])) picks_.push_back({i, picked, violation});
  return violation;
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
    matrix(a, a) += give_[a] + regularization;
    if (coupled_[a] != 0) matrix(a + 1, a) += coupled_[a];
    rhs_[a] = offset_[a] - rhs_[a];
  }
}

// delta = offset_ - give_ lambda - coupled_ of rows on lines.
void Pivoting::put_lines(const LawSystem& system) {
  for (Eigen::Index a = 0; a < lines_; ++a) {
    const int i = rows_[a];
    const Piece& piece = pieces_[i];
    give_[a] = coupled_[a] = offset_[a] = 0;
    if (piece.kind == Piece::sliding) {
      give_[a] = 1 / system.laws[i].viscosity;
      offset_[a] = give_[a] * piece.force;
    } else if (piece.kind == Piece::slipping) {
      const int second = system.laws[i].kind == LawKind::disk_second ? 1 : 0;
      const ConeTangent& tangent = tangents_[i - second];
      give_[a] = tangent.give(second, second);
      offset_[a] = tangent.offset[second];
      if (system.laws[i].kind == LawKind::disk_first) coupled_[a] = tangent.give(1, 0);
    }
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
    step[a] = offset_[a] - give_[a] * state.lambda[i] - state.delta[i];
  }
  for (Eigen::Index a = 0; a + 1 < lines_; ++a) {
    if (coupled_[a] == 0) continue;
    step[a] -= coupled_[a] * state.lambda[rows_[a + 1]];
    step[a + 1] -= coupled_[a] * state.lambda[rows_[a]];
  }
  cholesky_solve(matrix().topLeftCorner(lines_, lines_), step);
  for (Eigen::Index a = 0; a < lines_; ++a) state.lambda[rows_[a]] += step[a];
  update_displacements(system, state);
}

double Pivoting::work_of_pick(const LawSystem& system) const {
  const auto lines =
      std::count_if(pieces_.begin(), pieces_.begin() + system.rows(), [](const Piece& p) { return p.on_line(); });
  return StepBudget::factorisation(static_cast<double>(lines)) + 2 * StepBudget::product(system.rows()) +
         work_of_curves(system.laws);
}

// The forces with every row on its piece; false if the system of the rows on lines is not positive definite.
bool Pivoting::move(const LawSystem& system, const LawState& state) {
  number_rows(system.rows());
  put_lines(system);
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

double Pivoting::solve(const LawSystem& system, const LawState& state, const Ends& ends, StepBudget& budget,
                       int& picks) {
  const auto n = static_cast<std::size_t>(system.rows());
  const LawState trial{{trial_lambda_.data(), n}, {trial_delta_.data(), n}};
  update_displacements(system, state);
  copy(state, trial);
  double best = start(system, state);
  const bool curves = has_curves(system.laws);
  bool one_by_one = false;
  std::size_t fewest = n + 1;
  for (int i = 0; i < kMaxPicks && best > ends.begin && budget.take(work_of_pick(system)) && move(system, trial); ++i) {
    ++picks;
    const double residual = look(system, trial);
    if (residual < best) {
      best = residual;
      copy(trial, state);
    }
    if (picks_.empty()) {
      if (!curves || !(residual > ends.cones)) break;
      continue;
    }
    one_by_one = one_by_one || picks_.size() >= fewest;
    fewest = picks_.size();
    if (one_by_one) {
      put_piece(system, *std::ranges::max_element(picks_, {}, &Pick::violation));
    } else {
      for (const Pick& pick : picks_) put_piece(system, pick);
    }
  }
  return best;
}

}  // namespace acus
