// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/overrun_policy.h"

#include <doctest/doctest.h>

namespace acus {
namespace {

constexpr std::int64_t kTick = 1'000'000;  // ns
constexpr std::int64_t kRecovery = 10 * kTick;

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

TEST_CASE("a pause longer than the recovery ends the economy with the next punctual tick") {
  OverrunPolicy policy(kRecovery);
  policy.update(kTick, true);
  CHECK_FALSE(policy.update(1000 * kTick, false));
}

}  // namespace acus
