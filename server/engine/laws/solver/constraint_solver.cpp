// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/laws/solver/constraint_solver.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

namespace acus {

namespace {

// Whether a contact with friction is pressed, or there is none. Friction may hold it where it would open by itself:
// then both are answers, and the one goes on from which the forces come.
bool may_hold_by_friction(std::span<const Law> laws, std::span<const double> lambda) {
  bool any = false;
  for (int i = 0; i < static_cast<int>(laws.size()); ++i) {
    if (!is_contact(laws, i)) continue;
    if (lambda[static_cast<std::size_t>(i)] > 0) return true;
    any = true;
  }
  return !any;
}

void open(const LawSystem& system, const LawState& state) {
  std::fill(state.lambda.begin(), state.lambda.end(), 0.0);
  std::copy(system.delta_free.begin(), system.delta_free.end(), state.delta.begin());
}

}  // namespace

ConstraintSolver::ConstraintSolver(int capacity, std::size_t room)
    : room_(room), attempts_(capacity), reduced_(capacity, room_) {
  const auto n = static_cast<std::size_t>(capacity);
  scale_.resize(n);
  trial_lambda_.resize(n);
  trial_delta_.resize(n);
}

void ConstraintSolver::solve_rounds(std::span<const Attempt> attempts, double tolerance, const Target& target,
                                    const LawSystem& full, const LawState& state, StepBudget& budget,
                                    SolverResult& result) {
  const std::size_t n = state.lambda.size();
  const LawState trial{{trial_lambda_.data(), n}, {trial_delta_.data(), n}};
  for (int round = 0; round < kMaxRounds; ++round) {
    ++result.steps.rounds;
    reduced_.linearize(state);
    attempts_.run(attempts, tolerance, reduced_.system(), reduced_.others(), reduced_.room_behind(), budget, result);
    copy(state, trial);
    reduced_.expand(trial.lambda);
    update_displacements(full, trial);
    const double before = result.residual;
    const double residual = law_residual(full, trial);
    if (residual < before) {
      result.residual = residual;
      copy(trial, state);
    }
    if (result.residual <= target.at(state.lambda) || !(residual < before / 2)) break;
  }
  result.capped = budget.spent() && result.residual > target.at(state.lambda);
}

void ConstraintSolver::prefer_open(const LawSystem& full, const LawState& state, SolverResult& result) {
  const std::size_t n = state.lambda.size();
  const LawState trial{{trial_lambda_.data(), n}, {trial_delta_.data(), n}};
  open(full, trial);
  const double residual = law_residual(full, trial);
  if (residual >= result.residual) return;
  result.residual = residual;
  result.capped = false;
  copy(trial, state);
}

SolverResult ConstraintSolver::solve(LawMethod method, Eigen::Ref<const MatrixX> W, std::span<const Law> laws,
                                     std::span<const double> delta_free, StepBudget budget, double tolerance,
                                     std::span<double> lambda, std::span<double> delta) {
  const auto n = static_cast<Eigen::Index>(laws.size());
  assert(W.rows() >= n && W.cols() >= n && tolerance > 0);
  assert(delta_free.size() == laws.size() && lambda.size() == laws.size() && delta.size() == laws.size());
  law_scales(W, laws, scale_);
  const LawSystem full{W.topLeftCorner(n, n), laws, delta_free, {scale_.data(), laws.size()}};
  const LawState state{lambda, delta};
  assert(fits(full.rows(), static_cast<int>(std::ranges::count_if(
                               laws, [](const Law& law) { return law.kind != LawKind::bilateral; }))));
  const bool reducible = reduced_.reduce(full) && Eigen::Map<const VectorX>(delta_free.data(), n).allFinite();
  reduced_.gather(lambda);
  const bool may_be_held = may_hold_by_friction(laws, lambda);
  open(full, state);
  SolverResult result;
  result.residual = may_be_held ? std::numeric_limits<double>::infinity() : law_residual(full, state);
  const bool direct = method == LawMethod::direct;
  if (reducible && direct) {
    const Target end{.force = has_curves(laws) ? tolerance : 0, .share = kDirectEnd};
    solve_rounds(kDirect, tolerance / 2, end, full, state, budget, result);
    reduced_.gather(lambda);  // the best answer, not the last
  }
  const bool ends =
      direct && (budget.spent() || result.residual <= std::max(tolerance, kDirectEnd * force_scale(lambda)));
  // Half the tolerance, for what the elimination leaves over.
  if (reducible && !ends) solve_rounds(kGaussSeidel, tolerance / 2, {.force = tolerance}, full, state, budget, result);
  if (!(result.residual <= tolerance)) prefer_open(full, state, result);
  result.steps.work = budget.taken();
  result.fell_back = method == LawMethod::direct && result.sweeps > 0;
  result.method = result.fell_back ? LawMethod::gauss_seidel : method;
  result.converged = result.residual <= tolerance;
  return result;
}

}  // namespace acus
