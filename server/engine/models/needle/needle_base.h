// SPDX-License-Identifier: GPL-3.0-or-later
// The base of a needle: a prescribed one, or one on springs and dampers (held_base.h), which adds a step u of node 0,
// six unknowns. With F = -A⁻¹ A_10 the response of the free nodes to u, G = H_0 + H F that of the rows, S = A_00 + A_01
// F and K the holder's tangent, the solution for u = 0 (needle_linearization.h) changes by
//
//   u = (S + K)⁻¹ (w - r + Gᵀ lambda),   W_n += G (S + K)⁻¹ Gᵀ,   dq += F u
//
// w the holder's wrench and r the reaction, both before the step and without the rows' forces.
//
// Reaction. Of a flexible needle it is the residual of node 0, g_0 + A_01 dq_1 - (Hᵀ lambda)_0; of a rigid one inertia,
// drag
// - weight - Hᵀ lambda about the base: a command that jerks is felt without the compliance of a shaft.
#pragma once

#include "server/engine/models/needle/needle_scratch.h"

namespace acus {

// Adds the free step of a base on springs; false if S + K is not positive definite.
bool close_at_base(const NeedleModel& model, NeedleScratch& scratch);
// A row of G; `dq` is F.
Vector6 follow_node(const NeedleModel& model, const NeedleScratch& scratch, int row,
                    const Eigen::Ref<const MatrixX>& dq);
// A(0, 0); of a rigid needle that of all nodes about the base.
Matrix6 node_tangent(const NeedleModel& model, const NeedleScratch& scratch);

// ---- The linear response to a displacement (translation m, rotation vector rad, world) of the base at the end of the
// tick, or of its holder, at constant forces of the rows, by the linearisation of the last step; see base_stiffness.h
// ----

// Of the free nodes: 6 x free nodes rows, 6 columns.
void follow_base(const NeedleModel& model, const NeedleScratch& scratch, Eigen::Ref<MatrixX> dq);
// d(delta)/d(displacement) of a row (-, m), given the response of the free nodes.
Vector6 follow_base(const NeedleModel& model, const NeedleScratch& scratch, int row,
                    const Eigen::Ref<const MatrixX>& dq);
// d(reaction)/d(displacement), given the same; symmetric, N/m, N, N m.
Matrix6 base_tangent(const NeedleModel& model, const NeedleScratch& scratch, const Eigen::Ref<const MatrixX>& dq);

// The forces of the rows and the weight together, about node 0 (N, N m, world), after move_needle(): what the needle
// would pass to its holder at rest, without inertia and damping.
Vector6 lasting_wrench(const NeedleModel& model, const NeedleScratch& scratch);

}  // namespace acus
