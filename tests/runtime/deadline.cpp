// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/runtime/deadline.h"

#include <doctest/doctest.h>

namespace acus {
namespace {

void check_next(std::int64_t previous, std::int64_t period, std::int64_t now, std::int64_t time,
                std::uint64_t skipped) {
  const Deadline next = next_deadline(previous, period, now);
  CHECK(next.time == time);
  CHECK(next.skipped == skipped);
}

}  // namespace

TEST_CASE("work done in time goes on at the next deadline") {
  check_next(1000, 100, 1000, 1100, 0);
  check_next(1000, 100, 1099, 1100, 0);
  check_next(1000, 100, 1100, 1100, 0);
}

TEST_CASE("late work skips the deadlines that have passed") {
  check_next(1000, 100, 1101, 1200, 1);
  check_next(1000, 100, 1200, 1200, 1);
  check_next(1000, 100, 1201, 1300, 2);
  check_next(1000, 100, 5000, 5000, 39);
}

TEST_CASE("whatever the delays, ticks and skipped deadlines together stay on the grid, and none follow in a burst") {
  constexpr std::int64_t kPeriod = 1'000'000;
  std::int64_t deadline = 0;
  std::uint64_t ticks = 0, skipped = 0;
  for (std::int64_t i = 0; i < 1000; ++i, ++ticks) {
    const std::int64_t work = (i * 7919) % 3'500'000;
    const std::int64_t now = deadline + work;
    const Deadline next = next_deadline(deadline, kPeriod, now);
    CHECK(next.time >= now);
    CHECK(next.time - now < kPeriod + (work <= kPeriod ? kPeriod : 0));
    deadline = next.time;
    skipped += next.skipped;
  }
  CHECK(deadline == static_cast<std::int64_t>(ticks + skipped) * kPeriod);
}

}  // namespace acus
