// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/replay/latency.h"

#include <doctest/doctest.h>

#include <numeric>

using acus::client::distribution_of;
using acus::client::percentile;

TEST_CASE("percentiles are values of the set, by nearest rank") {
  const std::vector<double> values{1, 2, 3, 4, 5};
  CHECK(percentile(values, 0) == 1);
  CHECK(percentile(values, 0.2) == 1);
  CHECK(percentile(values, 0.21) == 2);
  CHECK(percentile(values, 0.5) == 3);
  CHECK(percentile(values, 1) == 5);
  CHECK(percentile({}, 0.5) == 0);
}

TEST_CASE("a distribution does not care for order") {
  std::vector<double> values(1000);
  std::iota(values.rbegin(), values.rend(), 1.0);
  const auto distribution = distribution_of(values);
  CHECK(distribution.count == 1000);
  CHECK(distribution.p50 == 500);
  CHECK(distribution.p99 == 990);
  CHECK(distribution.max == 1000);
  CHECK(distribution_of({}).count == 0);
}
