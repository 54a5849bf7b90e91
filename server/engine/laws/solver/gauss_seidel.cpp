// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/laws/solver/gauss_seidel.h"

#include "server/engine/laws/solver/sweep.h"

namespace acus {

GaussSeidel::Counts GaussSeidel::solve(const LawSystem& system, double tolerance, const LawState& state,
                                       StepBudget& budget) {
  Counts counts;
  update_displacements(system, state);
  while (law_residual(system, state) > tolerance && budget.take()) {
    sweep(system, state);
    ++counts.sweeps;
    if (counts.sweeps % kDirectAfter != 0) continue;
    update_displacements(system, state);  // rounding errors of the sweeps' running sums
    if (counts.sweeps == kDirectAfter) counts.direct += direct_.solve(system, state, budget);
  }
  return counts;
}

}  // namespace acus
