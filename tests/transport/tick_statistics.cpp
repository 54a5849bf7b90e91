// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/transport/tick_statistics.h"

#include <doctest/doctest.h>

namespace acus {

TEST_CASE("quantiles of tick times, the worst of everything else, and a fresh start after each period") {
  TickStatistics statistics;
  for (int i = 100; i >= 0; --i) {
    TickRecord tick;
    tick.timing = {i * 1e-3, 0, i * 1e-5, i * 1e-4, i > 98};
    tick.sweeps = i;
    tick.residual = 100 - i;
    if (i == 50) tick.flags = kPathFull;
    statistics.add(tick);
  }
  const protocol::Stats stats = statistics.take();
  CHECK(stats.ticks == 101);
  CHECK(stats.tick_p50 == doctest::Approx(0.050));
  CHECK(stats.tick_p99 == doctest::Approx(0.099));
  CHECK(stats.tick_max == doctest::Approx(0.100));
  CHECK(stats.wake_p50 == doctest::Approx(0.0005));
  CHECK(stats.wake_p99 == doctest::Approx(0.00099));
  CHECK(stats.wake_max == doctest::Approx(0.001));
  CHECK(stats.end_p50 == doctest::Approx(0.005));
  CHECK(stats.end_p99 == doctest::Approx(0.0099));
  CHECK(stats.end_max == doctest::Approx(0.01));
  CHECK(stats.late == 2);
  CHECK(stats.sweeps == 100);
  CHECK(stats.residual == 100);
  CHECK(stats.flags == kPathFull);

  const protocol::Stats empty = statistics.take();
  CHECK(empty.ticks == 0);
  CHECK(empty.tick_p50 == 0);
  CHECK(empty.tick_max == 0);
  CHECK(empty.end_max == 0);
  CHECK(empty.late == 0);
}

TEST_CASE("of few ticks, the one that a quantile asks for is not exceeded by more than it allows") {
  TickStatistics statistics;
  for (int i = 1; i <= 4; ++i) statistics.add({.timing = {.computing = i * 1e-3}});
  const protocol::Stats stats = statistics.take();
  CHECK(stats.tick_p50 == 2e-3);
  CHECK(stats.tick_p99 == 4e-3);
}

}  // namespace acus
