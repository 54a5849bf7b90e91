// SPDX-License-Identifier: GPL-3.0-or-later
// What the system may grant a real-time thread. Both log what they got; without it ticks still run, but may be late.
#pragma once

namespace acus {

// Keeps all memory of the process from being paged out.
void lock_memory();

// Lets the calling thread go before every ordinary one (SCHED_FIFO).
void raise_priority();

}  // namespace acus
