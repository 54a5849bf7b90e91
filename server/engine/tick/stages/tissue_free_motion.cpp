// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/models/tissue/tissue_linearization.h"
#include "server/engine/tick/stages/stages.h"

namespace acus {

void tissue_free_motion(const Model& model, const State& state, Scratch& scratch) {
  const StageTimer timer(scratch.times, Stage::tissue_free_motion);
  const bool exact = linearize_tissue(model.tissue_system, state.tissue, scratch.tissue);
  scratch.outcome.tangents_exact = scratch.outcome.tangents_exact && exact;
}

}  // namespace acus
