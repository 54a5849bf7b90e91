// SPDX-License-Identifier: GPL-3.0-or-later
// The step of the tissue for the forces found (tissue_linearization.h has the equation), and how far it is taken.
//
// For the lambda found dx goes down the merit Phi whose gradient is g(x) - Hᵀ lambda, at first with the slope -d,
// d = dxᵀ A dx = |y + Y S lambda|². Elements that are strained much, or swell near nu = 0.5 (the stiffness against
// turning then grows by lambda tr E), are stiffer than A. The slope at the end of a share s of the step is
//
//   -d + s dxᵀ (M/h² + B/h) dx + dxᵀ (f(x + s dx) - f(x)).
//
// Where it is above d, Phi has risen by the trapezoid rule, and so may kinetic and elastic energy together have without
// work done. Then s is cut by the secant rule. The check evaluates the elements, so it is made where a node moves far
// for its element, where a repeated step is no shorter than the one before, and for kGuardedTicks after a step whose
// end, known in the next tick, was too steep. Matrix `constant` is linear and needs none. The damping of the first step
// is that of a turned A, by the largest beta, which is never too small; otherwise that of the elements, as in g.
#pragma once

#include <span>

#include "server/engine/models/tissue/tissue_scratch.h"

namespace acus {

inline constexpr int kGuardedTicks = 100;   // linearisations
inline constexpr int kMaxTissueTrials = 8;  // of shares, in one step

// Checks the end of a tick's first step, scratch.step, where the elastic forces are known by now. Since the resistance
// is at most d, the elastic forces alone mostly show that it was not too steep.
void judge_step(const TissueSystem& system, const TissueStep& first, TissueScratch& scratch);

// The step with the rows' forces (N).
void solve_tissue(const TissueSystem& system, std::span<const double> lambda, TissueScratch& scratch);
// The share of the step, in (0, 1], that the forces at its end justify.
double trusted_tissue_share(const TissueSystem& system, TissueScratch& scratch);
// Moves x_k by a share of the step. Returns the largest change of a coordinate (m).
double move_tissue(const TissueSystem& system, double share, TissueScratch& scratch);

// The state at the end of the tick.
void commit_tissue(const TissueSystem& system, TissueScratch& scratch, TissueState& state);

}  // namespace acus
