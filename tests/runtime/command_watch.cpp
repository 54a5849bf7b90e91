// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/runtime/command_watch.h"

#include <doctest/doctest.h>

#include <limits>

using namespace acus;

TEST_CASE("commands are stale when none came for longer than the limit, and not before the first") {
  CommandMonitor watch({.time_step = 1e-3, .stale_after = 0.01, .ramp = 0.005});
  for (int i = 0; i < 100; ++i) CHECK_FALSE(watch.tick(false));
  CHECK_FALSE(watch.stale());
  CHECK(watch.age() == 0);
  CHECK_FALSE(watch.tick(true));
  for (int i = 0; i < 10; ++i) CHECK_FALSE(watch.tick(false));
  CHECK(watch.age() == doctest::Approx(0.01));
  CHECK(watch.tick(false));  // once
  CHECK_FALSE(watch.tick(false));
  CHECK(watch.stale());
  CHECK_FALSE(watch.tick(true));
  CHECK_FALSE(watch.stale());
}

TEST_CASE("commands of a client that is gone are stale at once, until another's come") {
  CommandMonitor watch({.time_step = 1e-3, .stale_after = 10, .ramp = 0.005});
  watch.abandon();
  CHECK_FALSE(watch.tick(false));  // nobody has commanded yet
  CHECK_FALSE(watch.tick(true));
  watch.abandon();
  CHECK(watch.tick(false));
  CHECK_FALSE(watch.tick(false));
  CHECK(watch.stale());
  CHECK(watch.age() == doctest::Approx(2e-3));
  CHECK_FALSE(watch.tick(true));
  CHECK_FALSE(watch.stale());
}

TEST_CASE("the force falls to nothing in the ramp and comes back in it, never by more than a tick's share") {
  CommandMonitor watch({.time_step = 1e-3, .stale_after = 0.01, .ramp = 0.02});
  double before = watch.force_share();
  CHECK(before == 1);
  int ticks_down = 0;
  watch.tick(true);
  for (int i = 0; i < 60; ++i) {
    watch.tick(false);
    CHECK(std::abs(watch.force_share() - before) < 0.05 + 1e-12);
    ticks_down += watch.force_share() < before ? 1 : 0;
    before = watch.force_share();
  }
  CHECK(ticks_down == 20);
  CHECK(before == 0);
  for (int i = 0; i < 20; ++i) watch.tick(true);
  CHECK(watch.force_share() == doctest::Approx(1));
}

TEST_CASE("a new epoch gives no force back before its first command") {
  CommandMonitor watch({.time_step = 1e-3, .stale_after = 0.01, .ramp = 0.02});
  for (int i = 0; i < 100; ++i) watch.tick(i == 0);
  watch.begin_epoch();
  CHECK(watch.age() == 0);
  CHECK_FALSE(watch.stale());
  for (int i = 0; i < 100; ++i) watch.tick(false);
  CHECK(watch.force_share() == 0);
  watch.tick(true);
  CHECK(watch.force_share() == doctest::Approx(0.05));
}

TEST_CASE("without a ramp the force goes at once, and an infinite limit leaves it whole") {
  CommandMonitor sudden({.time_step = 1e-3, .stale_after = 0.01, .ramp = 0});
  CommandMonitor never({.time_step = 1e-3, .stale_after = std::numeric_limits<double>::infinity(), .ramp = 0.01});
  for (int i = 0; i < 1000; ++i) sudden.tick(i == 0), never.tick(i == 0);
  CHECK(sudden.force_share() == 0);
  CHECK(never.force_share() == 1);
  CHECK_FALSE(never.stale());
}

TEST_CASE("the share of fresh ticks is that of the last hundred") {
  CommandMonitor watch;
  for (int i = 0; i < 50; ++i) watch.tick(true);
  CHECK(watch.fresh_share() == doctest::Approx(0.5));
  for (int i = 0; i < 100; ++i) watch.tick(i % 4 == 0);
  CHECK(watch.fresh_share() == doctest::Approx(0.25));
}

TEST_CASE("numbers that are missing are lost, numbers that do not rise are reordered") {
  CommandOrigin origin;
  std::uint64_t last = 0;
  for (const std::uint64_t seq : {7u, 8u, 11u, 10u, 12u, 12u}) count_command(origin, last, seq, 0.5);
  CHECK(origin.lost == 1);       // 9
  CHECK(origin.reordered == 2);  // 10, and 12 again
  CHECK(origin.time == 0.5);
}
