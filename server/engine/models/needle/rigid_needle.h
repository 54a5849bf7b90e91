// SPDX-License-Identifier: GPL-3.0-or-later
// A rigid needle: node 0 carries all others, so that forces act, and steps are, about it.
#pragma once

#include "server/engine/models/needle/needle_scratch.h"

namespace acus {

// A force and a moment on a node, as a force and a moment on node 0.
Vector6 about_base(const NeedleScratch& scratch, int node, const Vector6& wrench);

// The step of the tip (m) by that of the base, scratch.base_step.
Vector3 step_of_tip(const NeedleScratch& scratch);

// Moves from q_k by a share of the base's step; `to` may be q_k itself.
void turn_about_base(const NeedleModel& model, const NeedleScratch& scratch, double share, NeedleConfiguration& to);

}  // namespace acus
