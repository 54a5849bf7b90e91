// SPDX-License-Identifier: GPL-3.0-or-later
// What a tick told, for a hash: two runs that go apart show it here first.
#pragma once

#include "server/engine/math/hasher.h"
#include "server/engine/state/report.h"

namespace acus {

// Takes no memory.
void add_report(Hasher& hasher, const TickReport& report);

}  // namespace acus
