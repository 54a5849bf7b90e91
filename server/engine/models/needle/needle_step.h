// SPDX-License-Identifier: GPL-3.0-or-later
// The step of a needle for the forces found (needle_linearization.h has the equation), how far it is taken, and what
// comes of it.
#pragma once

#include <span>

#include "server/engine/models/needle/needle_scratch.h"

namespace acus {

// The step with the rows' forces (N).
void solve_needle(const NeedleModel& model, std::span<const double> lambda, NeedleScratch& scratch);
// Whether a node turns by more than 0.05 rad in the step: too far for a single linearisation.
bool turns_far(const NeedleScratch& scratch);
// The share of the step, in (0, 1], that the forces at its end justify: a beam that turns by theta in a step is
// stretched by L theta²/2, which the linearisation does not contain. As in tissue_step.h, with every term of g.
double trusted_needle_share(const NeedleModel& model, const NeedleState& state, NeedleScratch& scratch);
// Moves q_k by a share of the step and sets the reaction. Returns the largest change of a position (m).
double move_needle(const NeedleModel& model, double share, NeedleScratch& scratch);

// ---- Of the tick that commit_needle() will end ----

// Sum over the nodes of inertia and mass-proportional drag less weight (N): the base's reaction and the forces of the
// laws sum to it.
Vector3 inertia_less_weight(const NeedleModel& model, const NeedleScratch& scratch, const NeedleState& state);

struct NeedleEnergyChange {
  double stored;  // J, kinetic and elastic, at the end
  double gained;  // J, stored beyond what was stored before and the work of base, laws and weight. Backward Euler and
                  // damping take energy: it is not above zero where ticks are short enough for the needle
};
// The base's turn strains nothing: the energy stored at the start of the tick is that of q_0.
NeedleEnergyChange energy_change(const NeedleModel& model, const NeedleScratch& scratch, const NeedleState& state);
// Of all beams: |l/L - 1| of the chord and curvature times radius (-).
double largest_strain(const NeedleModel& model, const NeedleScratch& scratch);

// The state at the end of the tick.
void commit_needle(const NeedleScratch& scratch, NeedleState& state);

}  // namespace acus
