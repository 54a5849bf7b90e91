// SPDX-License-Identifier: GPL-3.0-or-later
// The rows of a tick as forces on the tissue's nodes. A row is the free displacement and the compliance (tissue_rows.h)
// of what its unit force acts on.
#pragma once

#include <span>

#include "server/engine/models/geometry/material_point.h"
#include "server/engine/models/tissue/tissue_scratch.h"

namespace acus {

// All of these return the number of the row, from 0 after clear(), or -1 if the corridor is full.
//
// A row whose unit force acts as `force` at a point.
int add_tissue_row(const TissueSystem& system, const TissuePoint& point, const Vector3& force, TissueScratch& scratch);
// Likewise over several points whose weights sum to 1 all together.
int add_tissue_row(const TissueSystem& system, std::span<const MaterialPoint> points, const Vector3& force,
                   TissueScratch& scratch);
// A row whose unit force turns the material of a tetrahedron by a couple `torque` (m): the nodal forces
// 1/2 torque x grad N_k, dual to material_rotation().
int add_tissue_couple(const TissueSystem& system, int tetrahedron, const Vector3& torque, TissueScratch& scratch);
// A row that does not act on the tissue.
int add_empty_tissue_row(TissueScratch& scratch);
// Sets the lower triangle of W to the compliance of the rows (m/N) and adds their free displacements (m) to `delta`.
void set_tissue_compliance(const TissueSystem& system, Eigen::Ref<MatrixX> W, std::span<double> delta,
                           TissueScratch& scratch);

// Goes on with what rows on a tetrahedron will need, and keeps what is there from being replaced soon; false if all is
// there or there is no room.
bool prepare_tissue(const TissueSystem& system, int tetrahedron, TissueScratch& scratch);

}  // namespace acus
