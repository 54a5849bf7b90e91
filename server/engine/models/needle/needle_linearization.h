// SPDX-License-Identifier: GPL-3.0-or-later
// The motion of a needle (needle.h) in a tick, linearised about the configuration q_k,
//
//   (M/h² + B/h + K) dq = -g(q_k) + Hᵀ lambda
//   g(q) = M((q - q_n)/h - v_n)/h + f(q) + B (q - q_n)/h - w
//
// with lumped M, B = alpha M + beta K_m, K the exact Hessian of the elastic energy and K_m its material part. q_0 is
// q_n carried along rigidly with the base, so that a turn of the base stretches no beam. The stiffness-proportional
// damping acts on q - q_0 alone: a rigid motion is not damped by it.
//
// Buckling. A needle that is pressed by more than it could bear with a free tip has a tangent that is not positive
// definite, although the tissue around its end supports it. The tissue is no part of the tangent, so springs across the
// end replace it there, 8^i x 3 EI/L³ for i = 1 up to the first that suffices, at most 3. They act on q - q_k and so
// put no force into g: they shorten steps and leave equilibria where they are. Where none suffices the needle buckles,
// and the material part is its tangent.
//
// A rigid needle has no free nodes: dq = 0, and g is inertia, with mass-proportional drag, - weight, summed over the
// nodes about the base. needle_base.h has what a base on springs adds.
#pragma once

#include "server/engine/models/needle/needle_scratch.h"

namespace acus {

// Starts a tick from `state` with the base, or what holds it, at its new pose; `before` is the holder's pose before.
void begin_needle(const NeedleModel& model, const NeedleState& state, const Pose& base, const Pose& before,
                  NeedleScratch& scratch);

// Linearises about q_k and solves for the free motion. `held`: number of nodes, from the tip, that tissue supports
// sideways. True if the exact tangent was positive definite.
bool linearize_needle(const NeedleModel& model, const NeedleState& state, int held, NeedleScratch& scratch);

}  // namespace acus
