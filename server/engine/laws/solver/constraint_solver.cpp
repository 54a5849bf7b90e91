// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/laws/solver/constraint_solver.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace acus {

ConstraintSolver::ConstraintSolver(int capacity) : direct_(capacity), gauss_seidel_(direct_), reduced_(capacity) {
  const auto n = static_cast<std::size_t>(capacity);
  scale_.resize(n);
  trial_lambda_.resize(n);
  trial_delta_.resize(n);
}

// Solves the reduced laws about the state, with `inner`, and again as long as that halves the residual, until it is
// within `target(lambda)`. The state ends as the best answer seen, the one that it came with included.
template <class Inner, class Target>
void ConstraintSolver::solve_rounds(const LawSystem& full, const LawState& state, SolverResult& result, Target target,
                                    Inner inner) {
  const std::size_t n = state.lambda.size();
  const LawState trial{{trial_lambda_.data(), n}, {trial_delta_.data(), n}};
  for (int round = 0; round < kMaxRounds; ++round) {
    reduced_.linearize(state);
    inner(reduced_.system(), reduced_.others());
    copy(state, trial);
    reduced_.expand(trial.lambda);
    update_displacements(full, trial);
    const double before = result.residual;
    const double residual = law_residual(full, trial);
    if (residual < before) {
      result.residual = residual;
      copy(trial, state);
    }
    if (result.residual <= target(state.lambda) || !(residual < before / 2)) return;
  }
}

void ConstraintSolver::solve_directly(const LawSystem& full, const LawState& state, StepBudget& budget,
                                      SolverResult& result) {
  const auto target = [](std::span<const double> lambda) { return kDirectEnd * force_scale(lambda); };
  solve_rounds(full, state, result, target, [&](const LawSystem& system, const LawState& others) {
    result.steps += direct_.solve(system, others, budget);
  });
  result.capped = budget.spent() && result.residual > target(state.lambda);
}

void ConstraintSolver::solve_by_sweeps(const LawSystem& full, double tolerance, const LawState& state,
                                       StepBudget& budget, SolverResult& result) {
  const auto target = [tolerance](std::span<const double>) { return tolerance; };
  solve_rounds(full, state, result, target, [&](const LawSystem& system, const LawState& others) {
    // Half the tolerance, for what the elimination leaves over.
    const GaussSeidel::Counts counts = gauss_seidel_.solve(system, tolerance / 2, others, budget);
    result.sweeps += counts.sweeps;
    result.steps += counts.direct;
  });
  result.capped = budget.spent() && result.residual > tolerance;
}

SolverResult ConstraintSolver::solve(LawMethod method, Eigen::Ref<const MatrixX> W, std::span<const Law> laws,
                                     std::span<const double> delta_free, int max_steps, double tolerance,
                                     std::span<double> lambda, std::span<double> delta) {
  assert(delta_free.size() == laws.size() && lambda.size() == laws.size() && delta.size() == laws.size());
  assert(laws.size() <= scale_.size() && max_steps >= 0 && tolerance > 0);
  const auto n = static_cast<Eigen::Index>(laws.size());
  assert(W.rows() >= n && W.cols() >= n);
  const LawSystem full{W.topLeftCorner(n, n), laws, delta_free, {scale_.data(), laws.size()}};
  const LawState state{lambda, delta};
  law_scales(full.W, laws, scale_);

  const bool reducible = reduced_.reduce(full);
  reduced_.gather(lambda);
  std::fill(lambda.begin(), lambda.end(), 0.0);
  std::copy(delta_free.begin(), delta_free.end(), delta.begin());
  SolverResult result;
  result.residual = law_residual(full, state);
  StepBudget budget(max_steps);
  bool by_sweeps = reducible && method == LawMethod::gauss_seidel;
  if (reducible && method == LawMethod::direct) {
    solve_directly(full, state, budget, result);
    reduced_.gather(lambda);  // the best answer, not the last
    by_sweeps = !budget.spent() && result.residual > std::max(tolerance, kDirectEnd * force_scale(lambda));
  }
  if (by_sweeps) solve_by_sweeps(full, tolerance, state, budget, result);
  result.fell_back = method == LawMethod::direct && result.sweeps > 0;
  result.method = result.fell_back ? LawMethod::gauss_seidel : method;
  result.converged = result.residual <= tolerance;
  return result;
}

}  // namespace acus
