// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/tick/stages/stages.h"

#include <cassert>

namespace acus {

void solve_laws(const Model& model, const State& state, Scratch& scratch) {
  const StageTimer timer(scratch.times, Stage::solve_laws);
  const LawSettings& laws = model.scene.laws;
  const int steps = state.economizing ? std::min(laws.max_steps, model.scene.overrun.max_steps) : laws.max_steps;
  assert(steps > 0);
  scratch.outcome.laws = scratch.rows.solve(laws.solver, steps, laws.tolerance);
  scratch.outcome.law_steps += scratch.outcome.laws.steps;
}

}  // namespace acus
