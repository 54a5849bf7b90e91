// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/runtime/delay_histogram.h"

#include <doctest/doctest.h>

namespace acus {

TEST_CASE("quantiles are too large by one bin at most, the largest delay is exact") {
  DelayHistogram delays;
  for (int i = 1; i <= 10000; ++i) delays.add(i * 1e-6);
  CHECK(delays.count() == 10000);
  for (const double q : {0.01, 0.5, 0.9, 0.99, 0.999}) {
    CHECK(delays.quantile(q) >= q * 1e-2 * (1 - 1e-12));
    CHECK(delays.quantile(q) <= q * 1e-2 * 1.045);
  }
  CHECK(delays.quantile(1) == 10000e-6);
  CHECK(delays.max() == 10000e-6);
}

TEST_CASE("a rare delay shows in the quantile that asks for it, and in no other") {
  DelayHistogram delays;
  for (int i = 0; i < 9999; ++i) delays.add(1e-4);
  delays.add(0.5);
  CHECK(delays.quantile(0.9999) < 1.1e-4);
  CHECK(delays.quantile(1) == 0.5);
}

TEST_CASE("delays of no length, and beyond the last bin, have their place") {
  DelayHistogram delays;
  CHECK(delays.quantile(0.5) == 0);
  delays.add(0);
  CHECK(delays.quantile(0.5) == 0);
  delays.add(-1e-9);
  delays.add(100);
  CHECK(delays.count() == 3);
  CHECK(delays.max() == 100);
  CHECK(delays.quantile(1) == 100);
}

}  // namespace acus
