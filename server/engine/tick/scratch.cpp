// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/tick/scratch.h"

#include "server/engine/state/limits.h"

namespace acus {

Scratch::Scratch(const Model& model, const Progress& progress)
    : guides(model.scene.guides.size()),
      tissue(model.tissue_system, model.max_rows,
             model.tissue_system.field ? max_held_nodes(model.scene)
                                       : max_touched_nodes(model.scene, shortest_edge(model.mesh))),
      paths_taken(kMaxPaths),
      needle_contacts(model.scene),
      rows(model.max_rows),
      contacts(model.max_rows),
      forces(model.scene.needles.size()),
      next_look(model.scene.needles.size()) {
  if (progress) progress("rows");
  const double spacing = least_spacing(model.scene.needles);
  for (int i = 0; i < model.needle_count(); ++i) {
    const Needle& needle = model.scene.needles[i];
    needles.emplace_back(model.needles[i], model.h,
                         max_tissue_rows(model.scene, needle) + max_rows_of_needles_alone(model.scene));
    insertions.emplace_back(max_shaft_points(needle, spacing), model.path_vertices, shaft_cells(needle));
    start_shapes.push_back(needles[i].shape());
    bases.push_back(base_at(needle.base));
  }
  events.reserve((kMaxCrossings + kOtherEvents) * model.scene.needles.size());
}

NeedleView needle_view(const Model& model, const Scratch& scratch, int needle) {
  return {model.needles[needle], scratch.start_shapes[needle], scratch.needles[needle].shape(), model.h};
}

TissueView tissue_view(const Model& model, const Matrix3X& x_start, const Matrix3X& x) {
  return {model.mesh,
          model.surface,
          model.borders,
          model.scene.tissue.regions,
          model.interactions,
          model.element_sizes,
          model.regions,
          x_start,
          x,
          model.scene.tissue.local_compliance == LocalCompliance::all,
          0,
          model.relaxation,
          model.tissue.free_index};
}

const Vector3& tip_cutting(const Model& model, const State& state, int needle) {
  const int path = state.insertions[needle].path;
  return model.cutting_directions[needle][path < 0 ? 0 : model.regions[state.paths[path].end.tetrahedron]];
}

InsertionView insertion_view(const Model& model, const State& state, const Scratch& scratch, int needle) {
  TissueView tissue = tissue_view(model, state.tissue.x, scratch.tissue.x);
  tissue.surface_moved = state.surface_moved;
  return {needle, model.scene.needles[needle], needle_view(model, scratch, needle), tissue,
          tip_cutting(model, state, needle)};
}

}  // namespace acus
