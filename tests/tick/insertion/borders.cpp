// SPDX-License-Identifier: GPL-3.0-or-later
// The border that a tip at the end of its path meets; the cube has another region below z = 0.
#include <doctest/doctest.h>

#include "server/engine/tick/insertion/finding/tip_place.h"
#include "tests/tick/insertion/bench_insertion.h"

namespace acus::test {
namespace {

std::optional<Obstacle> border_found(double puncture_force, double end, double tip, int held = -1, double cutting = 0) {
  InsertionBench bench(two_regions(puncture_force));
  bench.add_straight_path(end);
  bench.be_in_path(0);
  bench.state.border = held;
  bench.state.tip.cut.along = cutting;
  bench.put_needle(on_line(end));
  bench.move_needle(on_line(tip));
  return bench.locate().obstacle;
}

}  // namespace

TEST_CASE("a border within reach is an obstacle, and under the tip once it gets there") {
  CHECK_FALSE(border_found(0.7, 5e-3, 5e-3));
  const auto near = border_found(0.7, 5e-4, 5e-4);
  REQUIRE(near);
  CHECK_FALSE(near->under);
  CHECK(near->region == kLower);
  CHECK((near->at.position - on_line(0)).norm() < kRounding);
  CHECK((near->at.normal - Vector3::UnitZ()).norm() < kRounding);
  const auto reached = border_found(0.7, 5e-4, -1e-4);
  REQUIRE(reached);
  CHECK(reached->under);
}

TEST_CASE("a tip that cuts presses on a border from where that bears the same force on") {
  const double f_c = 0.2;
  const auto near = border_found(0.7, 5e-4, 0, -1, f_c);
  REQUIRE(near);
  CHECK_FALSE(near->under);
  CHECK(near->bears == doctest::Approx(f_c).epsilon(1e-9));
  const double deep = near->dimple.depth(f_c);
  CHECK(near->dimple_before == doctest::Approx(deep).epsilon(1e-9));
  CHECK(deep > 1e-4);
  CHECK_FALSE(border_found(0.7, 5e-4, -0.99 * deep, -1, f_c)->under);
  const auto pressed = border_found(0.7, 5e-4, -1.01 * deep, -1, f_c);
  CHECK(pressed->under);
  CHECK(pressed->bears == doctest::Approx(f_c).epsilon(1e-9));
}

TEST_CASE("a border that takes no more than the cut before it is no obstacle") {
  CHECK_FALSE(border_found(0.2, 5e-4, -1e-4));
  CHECK_FALSE(border_found(0.1, 5e-4, -1e-4));
}

TEST_CASE("a tip that a border holds finds it under its end") {
  const auto held = border_found(0.7, 0, 0, kLower);
  REQUIRE(held);
  CHECK(held->under);
  CHECK(held->region == kLower);
}

}  // namespace acus::test
