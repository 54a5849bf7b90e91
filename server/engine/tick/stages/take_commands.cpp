// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/models/needle/needle_linearization.h"
#include "server/engine/models/tissue/tissue_linearization.h"
#include "server/engine/tick/stages/stages.h"

namespace acus {

namespace {

int max_iterations(const Model& model, const State& state) {
  const int limit = model.max_tick_steps();
  return state.economizing ? std::min(limit, model.scene.overrun.max_iterations) : limit;
}

}  // namespace

void take_commands(const Model& model, const State& state, const Commands& commands, Scratch& scratch) {
  assert(commands.size() == static_cast<std::size_t>(model.needle_count() + model.guide_count()));
  scratch.times.seconds.fill(0);
  const StageTimer timer(scratch.times, Stage::take_commands);
  scratch.outcome = {};
  scratch.outcome.limit = max_iterations(model, state);
  scratch.events.clear();
  const std::uint64_t tick = state.tick + 1;
  for (int g = 0; g < model.guide_count(); ++g)
    begin_guide(model.guide_limits[g], model.h, state.guides[g], commands[model.needle_count() + g], tick,
                scratch.guides[g]);
  for (int i = 0; i < model.needle_count(); ++i) {
    scratch.bases[i] = follow(model.needle_limits[i], model.h, state.bases[i], commands[i], tick);
    put_shape(state.needles[i], scratch.start_shapes[i]);
    begin_needle(model.needles[i], state.needles[i], scratch.bases[i].spun_pose(), state.bases[i].spun_pose(),
                 scratch.needles[i]);
  }
  begin_tissue(model.tissue_system, state.tissue, scratch.tissue);
}

}  // namespace acus
