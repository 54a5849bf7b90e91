// SPDX-License-Identifier: GPL-3.0-or-later
// What the topic `haptics` says of a tick, as the haptic kit takes it (client/haptics/message.h), without the
// wire.
#pragma once

#include "client/haptics/local_model.h"
#include "server/engine/tick/simulation.h"

namespace acus {

// One tick in which needle 0, that does not spin, goes on to `target`, and its local model. `seq` is that of the
// command.
haptics::LocalModel step_with_local_model(Simulation& simulation, const Pose& target, std::uint64_t seq);

}  // namespace acus
