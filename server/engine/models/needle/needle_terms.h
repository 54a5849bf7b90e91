// SPDX-License-Identifier: GPL-3.0-or-later
// Terms of the residual g of a needle's motion and of its tangent (needle_linearization.h), one node or beam each.
#pragma once

#include "server/engine/models/needle/needle_scratch.h"

namespace acus {

// K_m of a beam, turned from q_0 to a configuration.
Matrix12 turned_material(const NeedleScratch& scratch, const NeedleConfiguration& at, int e);
// beta K_m (q - q_0)/h of a beam, K_m turned along. The turn is no part of what is damped: a needle that does not
// follow its base's spin is not pushed by it.
Vector12 beam_damping_force(const NeedleModel& model, const NeedleScratch& scratch, const NeedleConfiguration& at,
                            int e, const Matrix12& turned_material);
// M((q - q_n)/h - v_n)/h + alpha M (q - q_n)/h - w at one node.
Vector6 inertia_force(const NeedleModel& model, const NeedleScratch& scratch, const NeedleState& state,
                      const NeedleConfiguration& at, int node);
// M/h² + alpha M/h of one node, added to its block.
void add_inertia_tangent(const NeedleModel& model, const NeedleScratch& scratch, int node, Matrix6& block);
// g of a flexible needle at a configuration other than q_0.
void put_residual(const NeedleModel& model, const NeedleScratch& scratch, const NeedleState& state,
                  const NeedleConfiguration& at, Matrix6X& g);

}  // namespace acus
