// SPDX-License-Identifier: GPL-3.0-or-later
// Length of shaft in tissue without any row. Only tips meet surfaces: a shaft that comes from the side, or reaches over
// an edge beside its path, crosses tissue that does not act on it. A few samples are checked in each tick, the whole
// needle in every kMonitorPeriod.
#pragma once

#include "server/engine/tick/insertion/insertion.h"

namespace acus {

inline constexpr double kMonitorPeriod = 0.05;  // s

// Checks the next samples. `state` and `at` are those of the end of the tick.
void monitor_shaft(const InsertionView& at, const InsertionScratch& scratch, const Insertion& state,
                   ShaftMonitor& monitor);

}  // namespace acus
