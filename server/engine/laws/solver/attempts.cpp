// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/laws/solver/attempts.h"

#include <algorithm>
#include <cassert>
#include <limits>

#include "server/engine/laws/solver/sweep.h"

namespace acus {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

}  // namespace

Attempts::Attempts(int capacity) : pivoting_(capacity, room_), interior_point_(capacity, room_) {
  trial_lambda_.resize(static_cast<std::size_t>(capacity));
  trial_delta_.resize(static_cast<std::size_t>(capacity));
}

double Attempts::sweep_up_to(const Attempt& attempt, double end, const LawSystem& system, const LawState& state,
                             StepBudget& budget, SolverResult& result) {
  const bool looks = attempt.to == Attempt::To::tolerance;
  const double work = StepBudget::product(system.rows()) + work_of_curves(system.laws);
  double residual = looks ? law_residual(system, state) : kInfinity;
  for (int sweeps = 0; sweeps < attempt.sweeps && residual > end && budget.take(work); ++sweeps) {
    sweep(system, state);
    if ((sweeps + 1) % kFirstSweeps == 0) update_displacements(system, state);  // rounding errors of running sums
    ++result.steps.sweeps;
    if (!looks) continue;
    ++result.sweeps;
    residual = law_residual(system, state);
  }
  return residual;
}

// Contacts with friction and cones keep their forces, and what they miss is for the next picks; only a better answer
// counts.
double Attempts::try_interior_point(double residual, const LawSystem& system, const LawState& state, StepBudget& budget,
                                    SolverResult& result) {
  const LawState trial{{trial_lambda_.data(), state.lambda.size()}, {trial_delta_.data(), state.delta.size()}};
  copy(state, trial);
  result.steps.iterations += interior_point_.solve(system, trial, budget);
  const double tried = law_residual(system, trial);
  if (!(tried < residual)) return residual;
  copy(trial, state);
  return tried;
}

void Attempts::run(std::span<const Attempt> attempts, double tolerance, const LawSystem& system, const LawState& state,
                   std::span<double> room, StepBudget& budget, SolverResult& result) {
  assert(room.size() >= system.laws.size() * system.laws.size());
  room_ = room;
  update_displacements(system, state);
  const bool curves = has_curves(system.laws);
  const auto end_of = [&](const Attempt& attempt) {
    const bool to_tolerance = attempt.to == Attempt::To::tolerance || (curves && result.steps.picks > 0);
    return to_tolerance ? tolerance : std::min(tolerance, kRoundingEnd * force_scale(state.lambda));
  };
  double residual = kInfinity;  // until somebody looks
  for (const Attempt& attempt : attempts) {
    const double end = end_of(attempt);
    if (budget.spent()) return;
    switch (attempt.by) {
      case Attempt::By::sweeps:
        residual = sweep_up_to(attempt, end, system, state, budget, result);
        break;
      case Attempt::By::pivoting:
        residual = pivoting_.solve(system, state, {.begin = end, .cones = tolerance}, budget, result.steps.picks);
        break;
      case Attempt::By::interior_point:
        residual = try_interior_point(residual, system, state, budget, result);
        break;
    }
    if (!(residual > end_of(attempt))) return;
  }
}

}  // namespace acus
