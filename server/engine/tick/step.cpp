// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/tick/step.h"

namespace acus {

void step(const Model& model, const Commands& commands, State& state, Scratch& scratch, TickReport& report) {
  take_commands(model, state, commands, scratch);
  do {
    needle_free_motion(model, state, scratch);
    tissue_free_motion(model, state, scratch);
    locate(model, state, scratch);
    build_rows(model, state, scratch);
    compute_compliance(model, scratch);
    solve_laws(model, state, scratch);
    correct(model, state, scratch);
  } while (continues(model, scratch));
  scratch.outcome.finite = is_finite(model, scratch);
  if (scratch.outcome.finite) {
    commit(model, scratch, state);
    transitions(model, scratch, state);
    hold_ahead(model, scratch, state);
    look_ahead(model, state, scratch);
  }
  write_report(model, state, scratch, report);
}

}  // namespace acus
