// SPDX-License-Identifier: GPL-3.0-or-later
// A tick of a tissue with a deferred field (deferred_field.h): what tissue_linearization.h, tissue_row_forces.h and
// tissue_step.h do with such a one.
#pragma once

#include <span>

#include "server/engine/models/tissue/tissue_scratch.h"

namespace acus {

void begin_field(const TissueSystem& system, const TissueState& state, TissueScratch& scratch);
// The free motion of the held nodes, and a slice of the window's work.
void move_field_freely(const TissueSystem& system, const TissueState& state, TissueScratch& scratch);
// Holds a free node; false if there is no room for it.
bool hold_node(const TissueSystem& system, int free, TissueScratch& scratch);
// The step of the held nodes with the rows' forces (N).
void solve_field(const TissueSystem& system, std::span<const double> lambda, TissueScratch& scratch);
// Moves them by a share of it. Returns the largest change of a coordinate (m).
double move_field(const TissueSystem& system, double share, TissueScratch& scratch);
void commit_field(const TissueSystem& system, TissueScratch& scratch, TissueState& state);

// Between two ticks: holds the nodes of tetrahedra (-1: none) that needles will need soon. One that comes to be held is from
// now on where it really is, and not where it was shown.
void hold_ahead(const TissueSystem& system, std::span<const int> tetrahedra, TissueScratch& scratch, TissueState& state);

}  // namespace acus
