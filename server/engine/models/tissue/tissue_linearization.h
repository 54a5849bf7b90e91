// SPDX-License-Identifier: GPL-3.0-or-later
// One tick of the tissue: backward Euler, linearised about x_k,
//
//   A dx = -g(x_k) + Hᵀ lambda
//   g(x) = M((x - x_n)/h - v_n)/h + f(x) + B (x - x_n)/h - w
//
// with A of tissue_system.h.
//
//   constant       f(x) = K0 (x - X).
//   turned         A = R A0 Rᵀ with R the nodes' rotations, and exact forces f, so the resting shape is that of the
//                  corotational model itself. Residual and rows are turned into the rest frame (Rᵀ), the answer back.
//                  One linearisation is a tick of rung warped; repeated, the steps are those of a quasi-Newton method.
//   refactorized   A = M/h² + B/h + K(x_k) at every call, K the exact Hessian (R K0 Rᵀ where that is indefinite),
//                  B = alpha M + beta R K0 Rᵀ at the start of the tick.
//
// With y = L⁻¹ (-g) the rows (tissue_row_forces.h) enter as dx = L⁻ᵀ (y + Y S lambda).
#pragma once

#include "server/engine/models/tissue/tissue_scratch.h"

namespace acus {

void begin_tissue(const TissueSystem& system, const TissueState& state, TissueScratch& scratch);

// Linearises about x_k. True unless an indefinite Hessian was replaced.
bool linearize_tissue(const TissueSystem& system, const TissueState& state, TissueScratch& scratch);

}  // namespace acus
