// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/transport/rate_limiter.h"

#include <doctest/doctest.h>

namespace acus {
namespace {

using std::chrono::milliseconds;

int count_allowed(RateLimiter& limiter, const std::string& client, int tries, RateLimiter::Clock::time_point now) {
  int allowed = 0;
  for (int i = 0; i < tries; ++i) allowed += limiter.allow(client, now) ? 1 : 0;
  return allowed;
}

}  // namespace

TEST_CASE("a burst, then so many a second, for each client by itself") {
  RateLimiter limiter(10);
  const RateLimiter::Clock::time_point start{};
  CHECK(count_allowed(limiter, "a", 100, start) == 10);
  CHECK(count_allowed(limiter, "b", 100, start) == 10);
  CHECK(count_allowed(limiter, "a", 100, start + milliseconds(510)) == 5);
  CHECK(count_allowed(limiter, "a", 100, start + milliseconds(60000)) == 10);
}

TEST_CASE("many clients do not make it grow without bound") {
  RateLimiter limiter(1);
  const RateLimiter::Clock::time_point start{};
  for (int i = 0; i < 100000; ++i) CHECK(limiter.allow(std::to_string(i), start));
}

}  // namespace acus
