// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/privileges.h"

#include <pthread.h>
#include <sched.h>
#include <spdlog/spdlog.h>
#include <sys/mman.h>

#include <cerrno>
#include <cstring>

namespace acus {
namespace {

constexpr int kPriority = 50;  // of 1 to 99: above ordinary threads, below the kernel's own interrupt threads

}  // namespace

void lock_memory() {
  if (mlockall(MCL_CURRENT | MCL_FUTURE) == 0) {
    spdlog::info("memory is locked");
  } else {
    spdlog::warn("memory is not locked ({}): paging may make ticks late; raise the limit 'memlock' (ulimit -l)",
                 std::strerror(errno));
  }
}

void raise_priority() {
  sched_param parameters{};
  parameters.sched_priority = kPriority;
  const int error = pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters);
  if (error == 0) {
    spdlog::info("the simulation thread runs with SCHED_FIFO, priority {}", kPriority);
  } else {
    spdlog::warn(
        "the simulation thread runs without SCHED_FIFO ({}): other programs may make ticks late; raise the "
        "limit 'rtprio' (ulimit -r)",
        std::strerror(error));
  }
}

}  // namespace acus
