// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>

#include "server/engine/tick/insertion/finding/location.h"
#include "server/engine/tick/stages/stages.h"

namespace acus {

void locate(const Model& model, const State& state, Scratch& scratch) {
  if (scratch.outcome.iterations > 0) return;
  const StageTimer timer(scratch.times, Stage::locate);
  std::fill(scratch.paths_taken.begin(), scratch.paths_taken.end(), 0);
  for (int i = 0; i < model.needle_count(); ++i)
    locate_insertion(insertion_view(model, state, scratch, i), state.insertions[i], state.paths, scratch.paths_taken,
                     scratch.insertions[i]);
  for (int g = 0; g < model.guide_count(); ++g)
    locate_guide(needle_view(model, scratch, model.guide_needles[g]), scratch.guides[g]);
  find_needle_contacts(model, state, scratch.start_shapes, scratch.needles, scratch.needle_contacts);
}

}  // namespace acus
