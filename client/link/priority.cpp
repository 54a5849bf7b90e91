// SPDX-License-Identifier: MIT
#include "client/link/priority.h"

#include <sched.h>
#include <sys/mman.h>

namespace acus::client {

bool raise_priority() {
  constexpr int kPriority = 40;
  mlockall(MCL_CURRENT);
  sched_param parameters{};
  parameters.sched_priority = kPriority;
  return sched_setscheduler(0, SCHED_FIFO, &parameters) == 0;
}

void lower_priority() {
  const sched_param parameters{};
  sched_setscheduler(0, SCHED_OTHER, &parameters);
}

}  // namespace acus::client
