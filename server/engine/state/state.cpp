// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/state/state.h"

#include "server/engine/models/field/field_task.h"
#include "server/engine/state/capacities.h"
#include "server/engine/state/limits.h"
#include "server/engine/state/model.h"

namespace acus {

State make_state(const Model& model) {
  State state;
  state.tissue = make_tissue_state(model.tissue);
  if (model.tissue_system.field)
    state.tissue.field = make_field_state(model.tissue_system, max_held_nodes(model.scene));
  for (int i = 0; i < model.needle_count(); ++i) {
    const Pose& base = model.scene.needles[i].base;
    state.needles.push_back(make_needle_state(model.needles[i], base));
    state.bases.push_back(base_at(base));
    state.insertions.push_back(make_insertion(model.path_vertices, shaft_cells(model.scene.needles[i])));
  }
  state.monitors.resize(state.needles.size());
  for (const Guide& guide : model.scene.guides) state.guides.push_back({.motion = base_at(guide.pose)});
  state.paths.assign(kMaxPaths, Path(model.path_vertices));
  return state;
}

}  // namespace acus
