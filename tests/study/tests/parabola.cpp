// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/study/studies/parabola.h"

#include <doctest/doctest.h>

namespace acus::test {

TEST_CASE("the curvature of points on a parabola is the parabola's own, with its sign") {
  std::vector<double> x, y;
  for (int i = 0; i < 7; ++i) {
    x.push_back(0.01 * i);
    y.push_back(0.5 + 0.75 * x.back() - 2 * x.back() * x.back());
  }
  CHECK(parabola_curvature(x, y, 0.1875) == doctest::Approx(-4));                   // at the top, where the slope is 0
  CHECK(parabola_curvature(x, y, 0) == doctest::Approx(-4 / (1.5625 * 1.25)));  // slope 3/4: 1 + (3/4)² = 1.25²
}

}  // namespace acus::test
