// SPDX-License-Identifier: GPL-3.0-or-later
// Phases, kinds of events and flags are those that states carry: one list for both sides of the wire.
#pragma once

#include "protocol/enums.h"

namespace acus {

using protocol::EventKind;
using protocol::Phase;
using enum protocol::Flag;

}  // namespace acus
