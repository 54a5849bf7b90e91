// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/tick/stages/stages.h"

namespace acus {

void compute_compliance(const Model& model, Scratch& scratch) {
  const StageTimer timer(scratch.times, Stage::compute_compliance);
  const bool all = scratch.rows.assemble(model.needles, scratch.needles, model.tissue_system, scratch.tissue);
  scratch.outcome.rows_fit = scratch.outcome.rows_fit && all;
}

}  // namespace acus
