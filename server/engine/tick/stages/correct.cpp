// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>

#include "server/engine/tick/stages/stages.h"

namespace acus {

void correct(const Model& model, const State& state, Scratch& scratch) {
  const StageTimer timer(scratch.times, Stage::correct);
  Outcome& outcome = scratch.outcome;
  scratch.tissue.solve(scratch.rows.lambda());
  for (int i = 0; i < model.needle_count(); ++i) scratch.motions[i].solve(scratch.rows.needle_forces(i));
  // All bodies by the same share, so that action stays equal to reaction in work, too.
  outcome.share = scratch.tissue.trusted_share();
  for (int i = 0; i < model.needle_count(); ++i)
    outcome.share = std::min(outcome.share, scratch.motions[i].trusted_share(state.needles[i]));
  assert(outcome.share > 0 && outcome.share <= 1);
  outcome.change = scratch.tissue.move(outcome.share);
  for (NeedleMotion& motion : scratch.motions) outcome.change = std::max(outcome.change, motion.move(outcome.share));
  outcome.turned_far =
      std::any_of(scratch.motions.begin(), scratch.motions.end(), [](const NeedleMotion& m) { return m.turns_far(); });
  ++outcome.iterations;
}

bool goes_on(const Model& model, const Scratch& scratch) {
  const Outcome& outcome = scratch.outcome;
  if (outcome.iterations >= outcome.limit) return false;
  return model.iterates() ? outcome.change > model.scene.newton.tolerance : outcome.went_too_far();
}

}  // namespace acus
