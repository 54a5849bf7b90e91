// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/runtime/overrun_policy.h"

#include <doctest/doctest.h>

#include "server/runtime/link.h"

namespace acus {
namespace {

constexpr std::int64_t kTick = 1'000'000;  // ns
constexpr std::int64_t kRecovery = 10 * kTick;

// A loop that overruns at each tick with everything to do.
struct Overloaded {
  OverrunPolicy policy{kRecovery};
  std::int64_t tick = 0;

  // Ticks until the next attempt with everything, which overruns.
  std::int64_t wait() {
    policy.update(++tick * kTick, true);
    const std::int64_t begin = tick;
    while (policy.update(++tick * kTick, false)) REQUIRE(tick - begin < 1000);
    return tick - begin;
  }
};

}  // namespace

TEST_CASE("punctual ticks leave everything as it is") {
  OverrunPolicy policy(kRecovery);
  for (std::int64_t i = 1; i <= 100; ++i) CHECK_FALSE(policy.update(i * kTick, false));
  CHECK_FALSE(policy.economizing());
}

TEST_CASE("one tick that took too long is enough, and economy ends when the recovery has passed without another") {
  OverrunPolicy policy(kRecovery);
  CHECK(policy.update(5 * kTick, true));
  for (std::int64_t i = 6; i < 15; ++i) CHECK(policy.update(i * kTick, false));
  CHECK_FALSE(policy.update(15 * kTick, false));
  CHECK_FALSE(policy.update(16 * kTick, false));
}

TEST_CASE("every further one begins the recovery anew") {
  OverrunPolicy policy(kRecovery);
  for (std::int64_t i = 1; i <= 100; ++i) CHECK(policy.update(i * kTick, i % 9 == 1));
  CHECK(policy.update(109 * kTick, false));
  CHECK_FALSE(policy.update(110 * kTick, false));
}

TEST_CASE("a relapse doubles the recovery, within bounds") {
  Overloaded loop;
  for (const std::int64_t expected : {10, 20, 40, 80, 160, 320, 640, 640, 640}) CHECK(loop.wait() == expected);
}

TEST_CASE("a relapse is forgiven after as long a while as the recovery took") {
  Overloaded loop;
  for (const std::int64_t expected : {10, 20, 40}) CHECK(loop.wait() == expected);
  loop.tick += 38;  // the next overrun is one tick too early to be forgiven
  CHECK(loop.wait() == 80);
  loop.tick += 79;
  CHECK(loop.wait() == 10);
}

TEST_CASE("a tick overruns by its own work, whatever else made it late") {
  constexpr double kPeriod = 1e-3;  // s
  CHECK_FALSE(TickTiming{.work = 0.4e-3, .woke = 0, .ended = 0.5e-3}.overran(kPeriod));
  CHECK_FALSE(TickTiming{.work = 0.4e-3, .woke = 0.9e-3, .ended = 1.4e-3, .late = true}.overran(kPeriod));
  CHECK_FALSE(TickTiming{.work = 0.4e-3, .woke = 0, .ended = 3e-3, .late = true}.overran(kPeriod));  // interrupted
  CHECK(TickTiming{.work = 1.1e-3, .woke = 0, .ended = 1.2e-3, .late = true}.overran(kPeriod));
  CHECK(TickTiming{.work = 1.1e-3, .woke = 5e-3, .ended = 6.2e-3, .late = true}.overran(kPeriod));
}

TEST_CASE("a pause longer than the recovery ends the economy with the next punctual tick") {
  OverrunPolicy policy(kRecovery);
  policy.update(kTick, true);
  CHECK_FALSE(policy.update(1000 * kTick, false));
}

}  // namespace acus
