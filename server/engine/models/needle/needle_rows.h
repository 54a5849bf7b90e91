// SPDX-License-Identifier: GPL-3.0-or-later
// The rows of a tick on a needle: generalised forces on the nodes of one beam each.
#pragma once

#include <span>

#include "server/engine/models/needle/needle_scratch.h"

namespace acus {

// Adds a row whose generalised force is `force` on the nodes of `beam`; returns its index.
int add_needle_row(int beam, const Vector12& force, NeedleScratch& scratch);

// H dq_free (m) of a row.
double free_displacement(const NeedleModel& model, const NeedleScratch& scratch, int row);

// Adds W_n (m/N) to the lower triangle of W; row r of the needle is row places[r] there.
void add_needle_compliances(const NeedleModel& model, std::span<const int> places, Eigen::Ref<MatrixX> W,
                            NeedleScratch& scratch);

}  // namespace acus
