// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/models/tissue_scratch.h"

namespace acus {

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
  y.setZero(system.model.unknowns());
  on_fixed.resize(static_cast<std::size_t>(max_rows));
  if (system.matrix == TissueMatrix::refactorized && !system.empty()) {
    own_factor.emplace();
    system.assembler.assemble(x, element_rotations, Tangent::rest, tick_factors(system.h), matrix);
    own_factor->analyze(matrix, 3);
    own_factor->factorize(matrix);
  }
  panel_rows = factor(system).make_panel_rows();
  rows.emplace(factor(system), max_rows, max_nodes);
}

}  // namespace acus
