// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/simulation/stages/stages.h"

namespace acus {

void solve_laws(const Model& model, const State& state, Scratch& scratch) {
  const StageTimer timer(scratch.times, Stage::solve_laws);
  const LawSolver& laws = model.scene.laws;
  const int steps = state.economizing ? std::min(laws.max_sweeps, model.scene.overrun.max_sweeps) : laws.max_sweeps;
  scratch.outcome.laws = scratch.rows.solve(laws.solver, steps, laws.tolerance);
}

}  // namespace acus
