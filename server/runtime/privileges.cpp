// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/runtime/privileges.h"

#include <pthread.h>
#include <sched.h>
#include <spdlog/spdlog.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>

#include <cerrno>
#include <cstring>

namespace acus {
namespace {

constexpr int kSocketsPriority = 45;
constexpr unsigned long kTimerSlack = 1;  // ns; only ordinary threads have any

int set_policy(int policy, int priority) {
  sched_param parameters{};
  parameters.sched_priority = priority;
  return pthread_setschedparam(pthread_self(), policy, &parameters);
}

}  // namespace

int real_time_priority() {
  int policy = SCHED_OTHER;
  sched_param parameters{};
  pthread_getschedparam(pthread_self(), &policy, &parameters);
  return policy == SCHED_FIFO ? parameters.sched_priority : 0;
}

LockedMemory lock_memory() {
  if (mlockall(MCL_CURRENT) != 0) {
    spdlog::warn("memory is not locked ({}): paging may make ticks late; raise the limit 'memlock' (ulimit -l)",
                 std::strerror(errno));
    return LockedMemory::none;
  }
  const bool all = lock_new_memory();
  spdlog::info("memory is locked{}",
               all ? "" : ", but for what comes later: the limit 'memlock' is not infinite (ulimit -l)");
  return all ? LockedMemory::all : LockedMemory::present;
}

bool lock_new_memory() {
  rlimit limit{};
  const bool unlimited = getrlimit(RLIMIT_MEMLOCK, &limit) == 0 && limit.rlim_cur == RLIM_INFINITY;
  return mlockall(MCL_CURRENT | MCL_ONFAULT | (unlimited ? MCL_FUTURE : 0)) == 0 && unlimited;
}

void raise_priority(RealtimeThread thread) {
  const bool simulation = thread == RealtimeThread::simulation;
  const char* name = simulation ? "simulation thread runs" : "socket threads run";
  const int priority = simulation ? kSimulationPriority : kSocketsPriority;
  prctl(PR_SET_TIMERSLACK, kTimerSlack);
  const int error = set_policy(SCHED_FIFO, priority);
  const int granted = real_time_priority();
  if (error == 0) {
    spdlog::info("the {} with SCHED_FIFO, priority {}", name, granted);
  } else if (granted > 0) {
    spdlog::warn(
        "the {} with SCHED_FIFO, priority {} instead of {} ({}): the server's other threads may make ticks late; "
        "raise the limit 'rtprio' (ulimit -r)",
        name, granted, priority, std::strerror(error));
  } else {
    spdlog::warn(
        "the {} without SCHED_FIFO ({}): other programs may make ticks late; raise the limit 'rtprio' (ulimit -r)",
        name, std::strerror(error));
  }
}

void raise_connection_limit() {
  rlimit files{};
  if (getrlimit(RLIMIT_NOFILE, &files) != 0) return;
  files.rlim_cur = files.rlim_max;
  setrlimit(RLIMIT_NOFILE, &files);
  getrlimit(RLIMIT_NOFILE, &files);
  spdlog::info("room for {} connections, less some files: the limit 'nofile' (ulimit -n)", files.rlim_cur);
}

void lower_priority() { set_policy(SCHED_OTHER, 0); }

}  // namespace acus
