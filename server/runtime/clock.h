// SPDX-License-Identifier: GPL-3.0-or-later
// The system's clocks in whole nanoseconds, for loops that must neither drift nor be late. None of them follows what
// sets the time of day.
#pragma once

#include <time.h>

#include <cerrno>
#include <cstdint>

namespace acus {

inline constexpr std::int64_t kNanoseconds = 1'000'000'000;  // in a second

inline std::int64_t now_on(clockid_t clock) {
  timespec now;
  clock_gettime(clock, &now);
  return now.tv_sec * kNanoseconds + now.tv_nsec;
}

inline std::int64_t monotonic_now() { return now_on(CLOCK_MONOTONIC); }
inline std::int64_t processor_now() { return now_on(CLOCK_THREAD_CPUTIME_ID); }  // of this thread alone

// Until then on the monotonic clock; signals do not shorten it.
inline void sleep_until(std::int64_t time) {
  const timespec deadline{time / kNanoseconds, time % kNanoseconds};
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &deadline, nullptr) == EINTR) {
  }
}

}  // namespace acus
