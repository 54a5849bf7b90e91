// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/models/tissue/tissue_scratch.h"

#include <cmath>

namespace acus {

namespace {

auto copies_of(const FieldWindow& window) {
  decltype(FieldScratch::windows) copies;
  for (auto& copy : copies) copy = std::make_shared<FieldWindow>(window);
  return copies;
}

}  // namespace

FieldScratch::FieldScratch(const TissueSystem& system, int room)
    : now(make_field_state(system, room)),
      windows(copies_of(*now.window)),
      worker(system, windows.back()),
      held_of(system.position.size(), -1) {
  now.window = windows.front();
  v.setZero(3, system.model.nodes());
  for (std::vector<int>* list : {&slots, &read_of}) list->reserve(static_cast<std::size_t>(room));
  held_in.assign(static_cast<std::size_t>(room), -1);
  for (Matrix3X* list : {&moved_by_p, &moved_by_defect, &p_free, &free_motion, &moved, &step, &force})
    list->setZero(3, room);
  products.setZero(3 * room);
  d_free = shift = modes = of_held = now.d;
}

TissueScratch::TissueScratch(const TissueSystem& system, int max_rows, int max_nodes)
    : element_rotations(system.model),
      start_rotations(element_rotations),
      elements(system.model),
      trial_rotations(element_rotations) {
  x = trial_x = system.model.mesh->nodes;
  elastic.setZero(3, system.model.nodes());
  step = trial_forces = velocity = damping_force = elastic;
  rotations.setZero(4, system.model.nodes());
  rotations.row(0).setOnes();
  rotation_sums.setZero(4, system.rotation_grid.points);
  if (system.memory) crept.resize(system.memory->given.size());
  y.setZero(system.model.unknowns());
  on_fixed.resize(static_cast<std::size_t>(max_rows));
  if (system.matrix == TissueMatrix::refactorized && !system.empty()) {
    own_factor.emplace();
    system.assembler.assemble(x, element_rotations, Tangent::rest, tick_factors(system.h), matrix);
    own_factor->analyze(matrix, 3);
    own_factor->factorize(matrix);
    own_factor->keep(Precision::double_precision);
  }
  panel_rows = factor(system).make_panel_rows();
  rows.emplace(factor(system), max_rows, max_nodes, system.field ? &system.field->stiffening : nullptr);
  if (system.field) field.emplace(system, rows->corridor().capacity());
}

bool TissueScratch::finite() const {
  if (!field) return x.allFinite() && step.allFinite();
  return std::isfinite(field->now.window->size) &&
         field->step.leftCols(static_cast<Eigen::Index>(field->now.held.size())).allFinite();
}

}  // namespace acus
