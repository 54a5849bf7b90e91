// SPDX-License-Identifier: GPL-3.0-or-later
// Needles that are pushed on, and what holds then in every world.
#pragma once

#include "server/engine/tick/simulation.h"

namespace acus::fuzz {

// Tells every needle to go on by `distance` (m), or as far as it may go in a tick, and makes a tick.
void push(Simulation& simulation, double distance = 4e-4);

// Pushes for thirty ticks. After each the state is one that a snapshot could have, and the forces are numbers.
void push_on(Simulation& simulation);

}  // namespace acus::fuzz
