// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/math/step_share.h"

#include <doctest/doctest.h>

#include <limits>

namespace acus {
namespace {

TEST_CASE("a share is cut to where the secant of the slopes is zero, between a tenth and a half") {
  CHECK(cut_share(1, 1, 3) == doctest::Approx(0.25));
  CHECK(cut_share(0.5, 1, 3) == doctest::Approx(0.125));
  CHECK(cut_share(1, 1, 1.1) == doctest::Approx(1 / 2.1));
  CHECK(cut_share(1, 1, 1e9) == doctest::Approx(0.1));
}

TEST_CASE("a slope that is not finite cuts to a tenth") {
  CHECK(cut_share(1, 1, std::numeric_limits<double>::infinity()) == doctest::Approx(0.1));
  CHECK(cut_share(1, 1, std::numeric_limits<double>::quiet_NaN()) == doctest::Approx(0.1));
}

}  // namespace
}  // namespace acus
