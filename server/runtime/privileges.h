// SPDX-License-Identifier: GPL-3.0-or-later
// What the system may grant a real-time server. All log what they got; without it ticks still run, but may be late.
#pragma once

namespace acus {

// The simulation's deadlines come first; its sockets, whose threads pass poses and forces on, before everything else.
enum class RealtimeThread { simulation, sockets };

// Keeps all memory of the process from being paged out.
void lock_memory();

// Lets the calling thread, and the threads that it starts from then on, go before every ordinary one (SCHED_FIFO), and
// wakes it when it asked to be woken, not some tens of microseconds later.
void raise_priority(RealtimeThread thread);

// Lets the process have as many connections as it may. At the limit ZeroMQ keeps a processor busy with trying.
void raise_connection_limit();

// Makes the calling thread an ordinary one, for work that can wait.
void lower_priority();

}  // namespace acus
