// SPDX-License-Identifier: GPL-3.0-or-later
// Preloaded into a process, makes its wall clock step by days at every look, to and fro. Other clocks are left alone.
#define _GNU_SOURCE
#include <stdatomic.h>
#include <sys/syscall.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>

static atomic_int looks;

static time_t step(void) { return (time_t)(atomic_fetch_add(&looks, 1) % 7 - 3) * 86400; }

int clock_gettime(clockid_t clock, struct timespec* now) {
  const int status = (int)syscall(SYS_clock_gettime, clock, now);
  if (status == 0 && clock == CLOCK_REALTIME) now->tv_sec += step();
  return status;
}

int gettimeofday(struct timeval* now, void* zone) {
  (void)zone;
  struct timespec time_now;
  const int status = clock_gettime(CLOCK_REALTIME, &time_now);
  now->tv_sec = time_now.tv_sec;
  now->tv_usec = time_now.tv_nsec / 1000;
  return status;
}

time_t time(time_t* to) {
  struct timespec now;
  clock_gettime(CLOCK_REALTIME, &now);
  if (to) *to = now.tv_sec;
  return now.tv_sec;
}
