// SPDX-License-Identifier: GPL-3.0-or-later
// Runs an experiment through its commands and the rest after them, and keeps what stability is judged by.
#pragma once

#include "tests/study/studies/experiment.h"
#include "tests/study/studies/stability_criteria.h"

namespace acus {

inline constexpr std::size_t kLeastTicks = 2000;
inline constexpr std::size_t kLeastRest = 500;  // ticks after the last command

// Throws SceneError where the scene is refused.
StabilitySeries run_to_rest(const Experiment& experiment);

// The largest distance between corresponding columns (3 x n, m) after the rigid motion of `x` that brings them closest
// in the mean square, weighed alike.
double distance_but_for_rigid_motion(const Matrix3X& x, const Matrix3X& reference);

}  // namespace acus
