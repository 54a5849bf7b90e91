// SPDX-License-Identifier: GPL-3.0-or-later
// How much of a needle stands in the tissue and feels nothing. Only tips meet surfaces: a shaft that comes from the side,
// or reaches over an edge beside its path, crosses tissue that does not hold it. The needle is looked at in samples, a few
// a tick, so that all of it is seen every kWatchPeriod.
#pragma once

#include "server/engine/tick/insertion/insertion.h"

namespace acus {

inline constexpr double kWatchPeriod = 0.05;   // s, in which the whole needle is looked at

// Looks at the next samples. `memory` and the positions of `at` are those of the tick's end.
void watch_shaft(const InsertionView& at, const InsertionWork& work, const Insertion& memory, ShaftWatch& watch);

}  // namespace acus
