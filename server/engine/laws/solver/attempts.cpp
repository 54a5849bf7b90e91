// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/laws/solver/attempts.h"

#include <algorithm>

#include "server/engine/laws/solver/sweep.h"

namespace acus {

Attempts::Attempts(int capacity)
    : room_(VectorX::Zero(static_cast<Eigen::Index>(capacity) * capacity)),
      pivoting_(capacity, room_),
      interior_point_(capacity, room_) {
  trial_lambda_.resize(static_cast<std::size_t>(capacity));
  trial_delta_.resize(static_cast<std::size_t>(capacity));
}

int Attempts::sweep_up_to(int most, double end, const LawSystem& system, const LawState& state, StepBudget& budget) {
  int sweeps = 0;
  while (sweeps < most && law_residual(system, state) > end && budget.take()) {
    sweep(system, state);
    if (++sweeps % kFirstSweeps == 0) update_displacements(system, state);  // rounding errors of running sums
  }
  return sweeps;
}

// Contacts with friction keep their forces, and what they miss is for the next picks; only a better answer counts.
int Attempts::try_interior_point(const LawSystem& system, const LawState& state, StepBudget& budget) {
  const LawState trial{{trial_lambda_.data(), state.lambda.size()}, {trial_delta_.data(), state.delta.size()}};
  copy(state, trial);
  const int iterations = interior_point_.solve(system, trial, budget);
  if (law_residual(system, trial) < law_residual(system, state)) copy(trial, state);
  return iterations;
}

void Attempts::run(std::span<const Attempt> attempts, double tolerance, const LawSystem& system, const LawState& state,
                   StepBudget& budget, SolverResult& result) {
  update_displacements(system, state);
  for (const Attempt& attempt : attempts) {
    const bool to_tolerance = attempt.to == Attempt::To::tolerance;
    const double end = to_tolerance ? tolerance : std::min(tolerance, kRoundingEnd * force_scale(state.lambda));
    if (!(law_residual(system, state) > end) || budget.spent()) return;
    switch (attempt.by) {
      case Attempt::By::sweeps: {
        const int sweeps = sweep_up_to(attempt.sweeps, end, system, state, budget);
        if (to_tolerance) result.sweeps += sweeps;
        if (sweeps < attempt.sweeps) return;
        break;
      }
      case Attempt::By::pivoting:
        result.steps.picks += pivoting_.solve(system, state, budget);
        break;
      case Attempt::By::interior_point:
        result.steps.iterations += try_interior_point(system, state, budget);
        break;
    }
  }
}

}  // namespace acus
