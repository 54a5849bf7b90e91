// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <time.h>

namespace acus {

// Of this thread alone (s): what other programs take of the machine does not count.
inline double processor_time() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

// That some work takes (s).
template <class Work>
double processor_time_of(const Work& work) {
  const double start = processor_time();
  work();
  return processor_time() - start;
}

}  // namespace acus
