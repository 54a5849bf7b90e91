// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "server/engine/tick/stages/stages.h"

namespace acus {

// One tick of length h. A tick whose numbers stop being finite leaves the state as it was: flag not_finite.
void step(const Model& model, const Commands& commands, State& state, Scratch& scratch, TickReport& report);

}  // namespace acus
