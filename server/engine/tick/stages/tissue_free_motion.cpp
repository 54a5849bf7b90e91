// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/tick/stages/stages.h"

namespace acus {

void tissue_free_motion(const Model&, const State& state, Scratch& scratch) {
  const StageTimer timer(scratch.times, Stage::tissue_free_motion);
  const bool exact = scratch.tissue.linearize(state.tissue);
  scratch.outcome.tangents_exact = scratch.outcome.tangents_exact && exact;
}

}  // namespace acus
