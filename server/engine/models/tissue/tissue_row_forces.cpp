// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/models/tissue/tissue_row_forces.h"

#include "server/engine/models/field/field_tick.h"

namespace acus {

namespace {

void begin_row(TissueScratch& scratch) {
  scratch.rows->begin();
  scratch.on_fixed[scratch.rows->count()].setZero();
}

bool add_node(const TissueSystem& system, int node, const Vector3& force, TissueScratch& scratch) {
  const int free = system.model.free_index[node];
  if (free >= 0) {
    if (system.field && !hold_node(system, free, scratch)) return false;
    return scratch.rows->add_force(free, to_factor(system, scratch, node, force));
  }
  scratch.on_fixed[scratch.rows->count()] += force;
  return true;
}

bool add_part(const TissueSystem& system, const MaterialPoint& point, const Vector3& force, TissueScratch& scratch) {
  const auto& nodes = system.model.mesh->tetrahedra[point.tetrahedron];
  for (int k = 0; k < 4; ++k)
    if (point.weights[k] != 0 && !add_node(system, nodes[k], point.weights[k] * force, scratch)) return false;
  return true;
}

}  // namespace

int add_tissue_row(const TissueSystem& system, const TissuePoint& point, const Vector3& force, TissueScratch& scratch) {
  begin_row(scratch);
  if (!add_part(system, point.a, (1 - point.u) * force, scratch)) return -1;
  if (point.u > 0 && !add_part(system, point.b, point.u * force, scratch)) return -1;
  return scratch.rows->end();
}

int add_tissue_row(const TissueSystem& system, std::span<const MaterialPoint> points, const Vector3& force,
                   TissueScratch& scratch) {
  begin_row(scratch);
  for (const MaterialPoint& point : points)
    if (!add_part(system, point, force, scratch)) return -1;
  return scratch.rows->end();
}

int add_tissue_couple(const TissueSystem& system, int tetrahedron, const Vector3& torque, TissueScratch& scratch) {
  begin_row(scratch);
  const auto gradients = shape_gradients(*system.model.mesh, scratch.x, tetrahedron);
  for (int k = 0; k < 4; ++k)
    if (!add_node(system, system.model.mesh->tetrahedra[tetrahedron][k], 0.5 * torque.cross(gradients.col(k)), scratch))
      return -1;
  return scratch.rows->end();
}

int add_empty_tissue_row(TissueScratch& scratch) {
  begin_row(scratch);
  return scratch.rows->end();
}

void set_tissue_compliance(const TissueSystem& system, Eigen::Ref<MatrixX> W, std::span<double> delta,
                           TissueScratch& scratch) {
  if (!system.field) scratch.rows->read_displacements(scratch.y);
  scratch.rows->set_compliance(W, delta);
}

bool prepare_tissue(const TissueSystem& system, int tetrahedron, TissueScratch& scratch) {
  if (system.matrix == TissueMatrix::refactorized) return false;
  for (const int node : system.model.mesh->tetrahedra[tetrahedron]) {
    const int free = system.model.free_index[node];
    if (free >= 0 && scratch.rows->corridor().make_ahead(free)) return true;
  }
  return false;
}

}  // namespace acus
