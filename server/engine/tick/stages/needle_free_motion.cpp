// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/models/needle/needle_linearization.h"
#include "server/engine/tick/stages/stages.h"

namespace acus {

namespace {

// Nodes from the tip that tissue supports sideways: those inside, and that of a tip which presses on a surface.
int held_nodes(const NeedleModel& needle, const Insertion& insertion) {
  if (insertion.path < 0 && !touches(insertion)) return 0;
  return 1 + static_cast<int>(insertion.depth / needle.beam_length());
}

}  // namespace

void needle_free_motion(const Model& model, const State& state, Scratch& scratch) {
  const StageTimer timer(scratch.times, Stage::needle_free_motion);
  for (int i = 0; i < model.needle_count(); ++i) {
    const int held = held_nodes(model.needles[i], state.insertions[i]);
    const bool exact = linearize_needle(model.needles[i], state.needles[i], held, scratch.needles[i]);
    scratch.outcome.tangents_exact = scratch.outcome.tangents_exact && exact;
  }
}

}  // namespace acus
