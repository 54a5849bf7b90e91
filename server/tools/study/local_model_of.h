// SPDX-License-Identifier: GPL-3.0-or-later
// What the topic `haptics` would say of a tick, found without it: the stiffness along the needle's axis as a difference
// of two ticks from the same state, the limits from the laws of the tip.
#pragma once

#include "client/haptics/local_model.h"
#include "server/simulation/simulation.h"

namespace acus {

// One tick in which needle 0 goes on to `target`, and its local model. Makes the tick twice: the first time with the
// target a little further back. Other axes than the needle's have no stiffness. `seq` is that of the command.
haptics::LocalModel step_with_local_model(Simulation& simulation, const Pose& target, std::uint64_t seq);

}  // namespace acus
