// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/laws/solver/direct_laws.h"

#include "server/engine/laws/solver/sweep.h"

namespace acus {

DirectLaws::DirectLaws(int capacity) : pivoting_(capacity), interior_point_(capacity) {
  trial_lambda_.resize(static_cast<std::size_t>(capacity));
  trial_delta_.resize(static_cast<std::size_t>(capacity));
}

DirectSteps DirectLaws::solve(const LawSystem& system, const LawState& state, StepBudget& budget) {
  const LawState trial{{trial_lambda_.data(), state.lambda.size()}, {trial_delta_.data(), state.delta.size()}};
  DirectSteps steps;
  const auto violated = [&] { return law_residual(system, state) > kTurnsEnd * force_scale(state.lambda); };
  update_displacements(system, state);
  for (int k = 0; k < kSweeps && violated() && budget.take(); ++k) sweep(system, state);
  for (int turn = 0; turn < kMaxTurns && violated() && !budget.spent(); ++turn) {
    steps.picks += pivoting_.solve(system, state, budget);
    if (!violated()) break;
    copy(state, trial);
    steps.iterations += interior_point_.solve(system, trial, budget);
    // Contacts have not moved: what they miss is for the next round of picks to mend.
    if (law_residual(system, trial) < law_residual(system, state)) copy(trial, state);
  }
  return steps;
}

}  // namespace acus
