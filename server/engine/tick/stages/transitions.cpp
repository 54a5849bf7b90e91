// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/models/field/field_tick.h"
#include "server/engine/models/tissue/tissue_row_forces.h"
#include "server/engine/tick/insertion/transitions/path_transitions.h"

#include <algorithm>
#include <array>

#include "server/engine/state/limits.h"
#include "server/engine/tick/insertion/transitions/shaft_monitor.h"
#include "server/engine/tick/stages/stages.h"

namespace acus {

void transitions(const Model& model, Scratch& scratch, State& state) {
  const StageTimer timer(scratch.times, Stage::transitions);
  // No other needle that punctures may take the place of a path that one has picked up in this tick.
  for (int i = 0; i < model.needle_count(); ++i)
    if (scratch.insertions[i].located.reentered) state.paths[state.insertions[i].path].needle = i;
  for (int i = 0; i < model.needle_count(); ++i) {
    const InsertionView at = insertion_view(model, state, scratch, i);
    scratch.outcome.transitions |= insertion_transitions(
        {at, scratch.insertions[i], state.tick, state.insertions[i], state.paths, scratch.events});
    monitor_shaft(at, scratch.insertions[i], state.insertions[i], state.monitors[i]);
  }
}

void hold_ahead(const Model& model, Scratch& scratch, State& state) {
  if (!model.tissue_system.field) return;
  const StageTimer timer(scratch.times, Stage::transitions);
  for (int i = 0; i < model.needle_count(); ++i) {
    const InsertionView at = insertion_view(model, state, scratch, i);
    const auto ahead = [&](double distance) {
      return tetrahedron_ahead(at, scratch.insertions[i], state.insertions[i], state.paths, distance);
    };
    std::array<int, 2 + 2 * kPatchPoints> next{};
    std::size_t count = 0;
    next[count++] = ahead(0);
    if (next[0] >= 0) next[count++] = ahead(kHoldAhead * model.element_sizes[next[0]]);
    if (const auto patch = patch_ahead(at, state.insertions[i], state.paths, kSurfaceHeld))
      for (const auto& point : patch->points) next[count++] = point.tetrahedron;
    if (const auto& hub = scratch.insertions[i].located.hub)
      for (const auto& point : hub->patch.points) next[count++] = point.tetrahedron;
    hold_ahead(model.tissue_system, {next.data(), count}, scratch.tissue, state.tissue);
  }
}

void look_ahead(const Model& model, const State& state, Scratch& scratch) {
  const StageTimer timer(scratch.times, Stage::transitions);
  for (int i = 0; i < model.needle_count(); ++i) {
    if (state.tick < scratch.next_look[i]) continue;
    const InsertionView at = insertion_view(model, state, scratch, i);
    const auto ahead = [&](double distance) {
      return tetrahedron_ahead(at, scratch.insertions[i], state.insertions[i], state.paths, distance);
    };
    const auto prepare = [&](const ContactPatch& patch) {
      return std::ranges::any_of(patch.points, [&](const auto& p) {
        return prepare_tissue(model.tissue_system, p.tetrahedron, scratch.tissue);
      });
    };
    const int here = ahead(0);
    const auto patch = patch_ahead(at, state.insertions[i], state.paths, kSurfaceAhead);
    const auto& hub = scratch.insertions[i].located.hub;
    bool made = (patch && prepare(*patch)) || (hub && prepare(hub->patch));
    for (int step = 0; here >= 0 && step <= kStepsAhead && !made; ++step)
      made = prepare_tissue(model.tissue_system, ahead(step * kStepAhead * model.element_sizes[here]), scratch.tissue);
    if (!made) scratch.next_look[i] = state.tick + kLookEvery;
  }
}

}  // namespace acus
