// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>

#include "server/engine/models/needle/needle_step.h"
#include "server/engine/models/tissue/tissue_step.h"
#include "server/engine/tick/stages/stages.h"

namespace acus {

void correct(const Model& model, const State& state, Scratch& scratch) {
  const StageTimer timer(scratch.times, Stage::correct);
  Outcome& outcome = scratch.outcome;
  solve_tissue(model.tissue_system, scratch.rows.lambda(), scratch.tissue);
  for (int i = 0; i < model.needle_count(); ++i)
    solve_needle(model.needles[i], scratch.rows.needle_forces(i), scratch.needles[i]);
  // All bodies by the same share, so that action stays equal to reaction in work, too.
  outcome.share = trusted_tissue_share(model.tissue_system, scratch.tissue);
  for (int i = 0; i < model.needle_count(); ++i)
    outcome.share =
        std::min(outcome.share, trusted_needle_share(model.needles[i], state.needles[i], scratch.needles[i]));
  assert(outcome.share > 0 && outcome.share <= 1);
  outcome.change = move_tissue(model.tissue_system, outcome.share, scratch.tissue);
  for (int i = 0; i < model.needle_count(); ++i)
    outcome.change = std::max(outcome.change, move_needle(model.needles[i], outcome.share, scratch.needles[i]));
  outcome.turned_far = std::ranges::any_of(scratch.needles, turns_far);
  ++outcome.iterations;
}

bool continues(const Model& model, const Scratch& scratch) {
  const Outcome& outcome = scratch.outcome;
  if (outcome.iterations >= outcome.limit) return false;
  return model.iterates() ? outcome.change > model.scene.newton.tolerance : outcome.went_too_far();
}

}  // namespace acus
