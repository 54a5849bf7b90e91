// SPDX-License-Identifier: GPL-3.0-or-later
// What the system may grant a real-time server. All log what they got; without it ticks still run, but may be late.
#pragma once

namespace acus {

// The simulation's deadlines come first; its sockets, whose threads pass poses and forces on, before everything else.
enum class RealtimeThread { simulation, sockets };

// How much of the process' memory is not paged out.
enum class LockedMemory { none, present, all };

// Keeps memory from being paged out: brings in what is mapped now, and locks it. What is mapped later is locked page by
// page as it is used, so that a long message takes no more than has come of it. Under a finite limit 'memlock' it is
// not locked: the limit would count what is set aside, and allocations that go beyond it would fail. To be called
// before strangers can send anything.
LockedMemory lock_memory();
// Locks what has been mapped since, under a finite limit, too; brings nothing in. Whether what comes later is, too.
bool lock_new_memory();

// Of the simulation, of 1 to 99: above ordinary threads, below the kernel's own interrupt threads (50).
inline constexpr int kSimulationPriority = 49;
// That the calling thread has with SCHED_FIFO; 0 if it is an ordinary one. A thread inherits it from whoever started
// it, also where it may have no higher one of its own.
int real_time_priority();

// Lets the calling thread, and the threads that it starts from then on, go before every ordinary one (SCHED_FIFO), and
// wakes it when it asked to be woken, not some tens of microseconds later.
void raise_priority(RealtimeThread thread);

// Lets the process have as many connections as it may. At the limit ZeroMQ keeps a processor busy with trying.
void raise_connection_limit();

// Makes the calling thread an ordinary one, for work that can wait.
void lower_priority();

}  // namespace acus
