// SPDX-License-Identifier: MIT
// Real-time priority for clients whose poses have to be punctual.
#pragma once

namespace acus::client {

// For the calling thread and all that it starts from then on: SCHED_FIFO, below acus-server's simulation thread, with
// what is in memory now kept there. False if the system does not permit the priority (docs/operating.md).
bool raise_priority();
// Back to an ordinary thread, as for a server in lockstep, where nothing has to be punctual.
void lower_priority();

}  // namespace acus::client
