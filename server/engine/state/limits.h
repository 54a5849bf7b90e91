// SPDX-License-Identifier: GPL-3.0-or-later
// Bounds that are fixed before a scene is known.
#pragma once

namespace acus {

inline constexpr int kMaxPaths = 64;      // of a tissue
inline constexpr int kMaxTickSteps = 10;  // iterations of a tick in rungs of one step, where a step goes too far
inline constexpr int kLookEvery = 8;      // ticks between two searches ahead of a tip, while all that is there is ready
inline constexpr int kStepsAhead = 6;     // of a search for the tetrahedra that a tip will enter
inline constexpr double kStepAhead = 0.3;  // sizes of the tip's element
inline constexpr double kHoldAhead = 0.3;  // sizes of the tip's element, of a deferred field's node that is held
inline constexpr double kSurfaceHeld = 2e-3;    // m, of a surface that a tip will touch, likewise
inline constexpr double kSurfaceAhead = 20e-3;  // m, of a search for the surface that a tip will touch
inline constexpr int kOtherEvents = 8;          // events of one needle in one tick, besides the borders that it crosses

// Imbalance of forces, and change of those on the needles in the next tick, that together raise a flag: shares of the
// largest force, or of a needle's contact forces, their amounts added up: where friction turns round they oppose each
// other, and no force is large. Forces below kLeastForceToBalance, and sums within rounding (Model::force_rounding),
// raise none.
inline constexpr double kMaxImbalance = 0.03;         // -
inline constexpr double kLeastForceToBalance = 1e-3;  // N

// Share of its defects that a deferred field takes in, below which a flag is raised (models/field/deferred_field.h).
inline constexpr double kLeastShareUnnoticed = 0.4;  // -

// Energy gain of a needle in a tick that raises a flag, as a share of its stored energy, which counts as at least
// kLeastEnergyToGain.
inline constexpr double kMaxEnergyGain = 0.01;       // -
inline constexpr double kLeastEnergyToGain = 1e-6;   // J
// Strain of a needle that raises a flag: the error of the beams' forces is of this order. Likewise how far another
// needle is pressed into it, over the thinner one's radius.
inline constexpr double kMaxNeedleStrain = 0.05;     // -

}  // namespace acus
