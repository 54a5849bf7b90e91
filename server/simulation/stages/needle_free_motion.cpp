// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/simulation/stages/stages.h"

namespace acus {

void needle_free_motion(const Model& model, const State& state, Scratch& scratch) {
  const StageTimer timer(scratch.times, Stage::needle_free_motion);
  for (int i = 0; i < model.needle_count(); ++i) {
    const bool exact = scratch.motions[i].linearize(state.needles[i]);
    scratch.outcome.tangents_exact = scratch.outcome.tangents_exact && exact;
  }
}

}  // namespace acus
