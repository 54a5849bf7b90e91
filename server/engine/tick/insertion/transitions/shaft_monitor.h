// SPDX-License-Identifier: GPL-3.0-or-later
// Length of shaft in tissue without any row: what has come to be deep beside its path without a contact
// (shaft_contact.h), as by a jump of the base. Within 1.5 mm of what path or tip hold it counts as held. A few samples
// are checked in each tick, the whole needle in every kMonitorPeriod.
#pragma once

#include "server/engine/tick/insertion/insertion.h"

namespace acus {

inline constexpr double kMonitorPeriod = 0.05;  // s

// Checks the next samples. `state` and `at` are those of the end of the tick.
void monitor_shaft(const InsertionView& at, const InsertionScratch& scratch, const Insertion& state,
                   ShaftMonitor& monitor);

}  // namespace acus
