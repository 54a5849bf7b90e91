// SPDX-License-Identifier: GPL-3.0-or-later
// Where the tip stands in its path: mouth and vertices at 30, 26 and 22 mm, end at 20 mm.
#include <doctest/doctest.h>

#include "tests/simulation/insertion/bench_insertion.h"

namespace acus::test {
namespace {

const TipPlace& place_at(InsertionBench& bench, double z) {
  bench.add_straight_path(0.020);
  bench.be_in_path(0);
  bench.put_needle(on_line(z));
  return bench.locate().tip;
}

}  // namespace

TEST_CASE("a tip at the end of its path cuts") {
  InsertionBench bench;
  const TipPlace& tip = place_at(bench, 0.020);
  CHECK(tip.in_tail);
  CHECK(tip.at_end);
  CHECK(tip.softness == 0);
  CHECK(tip.offset == 0);
  CHECK((bench.view().tissue.position(tip.point) - on_line(0.020)).norm() < kRounding);
  CHECK((tip.tangent + Vector3::UnitZ()).norm() < kRounding);
}

TEST_CASE("the vertex behind a cutting tip fades in with its distance from the end") {
  InsertionBench bench;
  place_at(bench, 0.020);  // d = half a spacing: ((1 - d)/d)^2 = 1
  REQUIRE(bench.work.located.shaft.size() == 3);
  CHECK(bench.work.located.shaft[0].softness == 0);
  CHECK(bench.work.located.shaft[1].softness == 0);
  CHECK(bench.work.located.shaft[2].softness == doctest::Approx(1).epsilon(1e-9));
}

TEST_CASE("a tip back between two vertices is held to the point between them") {
  InsertionBench bench;
  const TipPlace& tip = place_at(bench, 0.023);  // u = 3/4
  CHECK_FALSE(tip.in_tail);
  CHECK_FALSE(tip.at_end);
  CHECK(tip.point.u == doctest::Approx(0.75).epsilon(1e-9));
  CHECK(tip.softness == doctest::Approx(1.0 / 16).epsilon(1e-9));
  CHECK(tip.offset == 0);
  CHECK((bench.view().tissue.position(tip.point) - on_line(0.023)).norm() < kRounding);
}

TEST_CASE("a tip back between the last vertex and the end has the end's offset in part") {
  InsertionBench bench;
  const TipPlace& tip = place_at(bench, 0.0215);  // u = 1/4
  CHECK(tip.in_tail);
  CHECK_FALSE(tip.at_end);
  CHECK(tip.point.u == doctest::Approx(0.25).epsilon(1e-9));
  CHECK(tip.softness == doctest::Approx(9.0 / 16).epsilon(1e-9));
  CHECK(tip.offset == doctest::Approx(0.25).epsilon(1e-9));
  CHECK(bench.work.located.shaft.back().softness == doctest::Approx(0.25).epsilon(1e-9));
}

TEST_CASE("a tip before the mouth is held to the mouth") {
  InsertionBench bench;
  const TipPlace& tip = place_at(bench, 0.031);
  CHECK_FALSE(tip.at_end);
  CHECK(tip.point.u == 0);
  CHECK(tip.softness == 0);
  CHECK((bench.view().tissue.position(tip.point) - on_line(kTop)).norm() < kRounding);
  CHECK(bench.work.located.shaft.empty());
}

TEST_CASE("a path that has left the tissue has no end to cut at") {
  InsertionBench bench;
  bench.add_straight_path(kBottom).exited = true;
  bench.be_in_path(0);
  bench.put_needle(on_line(kBottom));
  CHECK_FALSE(bench.locate().tip.in_tail);
  CHECK_FALSE(bench.work.located.tip.at_end);
}

}  // namespace acus::test
