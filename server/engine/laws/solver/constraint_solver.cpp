// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/laws/solver/constraint_solver.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

namespace acus {

namespace {

// Whether a contact with friction is pressed. Friction may hold it where it would open by itself: then both are
// answers, and the one goes on from which the forces come.
bool holds_by_friction(std::span<const Law> laws, std::span<const double> lambda) {
  for (int i = 0; i < static_cast<int>(laws.size()); ++i)
    if (is_contact(laws, i) && lambda[static_cast<std::size_t>(i)] > 0) return true;
  return false;
}

}  // namespace

ConstraintSolver::ConstraintSolver(int capacity) : attempts_(capacity), reduced_(capacity) {
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
    reduced_.linearize(state);
    attempts_.run(attempts, tolerance, reduced_.system(), reduced_.others(), budget, result);
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

SolverResult ConstraintSolver::solve(LawMethod method, Eigen::Ref<const MatrixX> W, std::span<const Law> laws,
                                     std::span<const double> delta_free, int max_steps, double tolerance,
                                     std::span<double> lambda, std::span<double> delta) {
  assert(max_steps >= 0);
  StepBudget budget(max_steps);
  eliminate(W, laws);
  return solve_again(method, W, laws, delta_free, budget, tolerance, lambda, delta);
}

LawSystem ConstraintSolver::system(const Eigen::Ref<const MatrixX>& W, std::span<const Law> laws,
                                   std::span<const double> delta_free) {
  const auto n = static_cast<Eigen::Index>(laws.size());
  assert(laws.size() <= scale_.size() && W.rows() >= n && W.cols() >= n);
  law_scales(W, laws, scale_);
  return {W.topLeftCorner(n, n), laws, delta_free, {scale_.data(), laws.size()}};
}

void ConstraintSolver::eliminate(Eigen::Ref<const MatrixX> W, std::span<const Law> laws) {
  reducible_ = reduced_.reduce(system(W, laws, {}));
}

SolverResult ConstraintSolver::solve_again(LawMethod method, Eigen::Ref<const MatrixX> W, std::span<const Law> laws,
                                           std::span<const double> delta_free, StepBudget& budget, double tolerance,
                                           std::span<double> lambda, std::span<double> delta) {
  assert(delta_free.size() == laws.size() && lambda.size() == laws.size() && delta.size() == laws.size());
  assert(tolerance > 0);
  const LawSystem full = system(W, laws, delta_free);
  const LawState state{lambda, delta};
  reduced_.replace_laws(full);
  reduced_.gather(lambda);
  const bool held = holds_by_friction(laws, lambda);
  const auto open_all = [&] {
    std::fill(lambda.begin(), lambda.end(), 0.0);
    std::copy(delta_free.begin(), delta_free.end(), delta.begin());
  };
  open_all();
  const double open = law_residual(full, state);
  SolverResult result;
  result.residual = held && std::isfinite(open) ? std::numeric_limits<double>::infinity() : open;
  const bool direct = method == LawMethod::direct;
  if (reducible_ && direct) {
    solve_rounds(kDirect, std::numeric_limits<double>::infinity(), {.share = kDirectEnd}, full, state, budget, result);
    reduced_.gather(lambda);  // the best answer, not the last
  }
  const bool ends =
      direct && (budget.spent() || result.residual <= std::max(tolerance, kDirectEnd * force_scale(lambda)));
  // Half the tolerance, for what the elimination leaves over.
  if (reducible_ && !ends) solve_rounds(kGaussSeidel, tolerance / 2, {.force = tolerance}, full, state, budget, result);
  if (held && open < result.residual && !(result.residual <= tolerance)) {
    result.residual = open;
    result.capped = false;
    open_all();
  }
  result.fell_back = method == LawMethod::direct && result.sweeps > 0;
  result.method = result.fell_back ? LawMethod::gauss_seidel : method;
  result.converged = result.residual <= tolerance;
  return result;
}

}  // namespace acus
