// SPDX-License-Identifier: GPL-3.0-or-later
// Bounds that are fixed before a scene is known.
#pragma once

namespace acus {

inline constexpr int kMaxPaths = 64;       // that a tissue remembers
inline constexpr int kMaxTickSteps = 10;   // of a tick in rungs that make one step, but where one goes too far
inline constexpr int kLookEvery = 8;       // ticks between two looks ahead of a tip, while all that lies there is ready
inline constexpr int kStepsAhead = 6;      // of a look for the tetrahedra that a tip will enter
inline constexpr double kStepAhead = 0.3;  // sizes of the tip's element
inline constexpr double kSurfaceAhead = 20e-3;  // m, of a look for the surface that a tip will touch
inline constexpr int kOtherEvents = 8;     // of one needle in one tick, besides the borders that it crosses

// The sum of all forces, of the largest of them, above which they are told as unbalanced, if that one is above the
// second and the sum is more than rounding (Model::force_rounding).
inline constexpr double kMaxImbalance = 0.03;         // -
inline constexpr double kLeastForceToBalance = 1e-3;  // N

// What a needle may gain in a tick that nobody put into it, of what it stores, and of a needle that stores so much.
inline constexpr double kMaxEnergyGain = 0.01;       // -
inline constexpr double kLeastEnergyToGain = 1e-6;   // J
// Beams have small strains: what they miss of their forces is of this order.
inline constexpr double kMaxNeedleStrain = 0.05;     // -

}  // namespace acus
