// SPDX-License-Identifier: GPL-3.0-or-later
// Where the tip stands in its path: mouth and vertices at 30, 26 and 22 mm, end at 20 mm.
#include <doctest/doctest.h>

#include "tests/tick/insertion/bench_insertion.h"

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
  CHECK(tip.supported == doctest::Approx(0.001).epsilon(1e-9));  // half of the way from the last vertex
  CHECK((bench.view().tissue.position(tip.point) - on_line(0.020)).norm() < kRounding);
  CHECK((tip.tangent + Vector3::UnitZ()).norm() < kRounding);
}

TEST_CASE("a tip beside its path's end is at the end as long as it is not back along its cutting direction") {
  InsertionBench bench;
  bench.add_straight_path(0.020);
  bench.be_in_path(0);
  bench.put_needle(on_line(0.020) + Vector3(2e-3, 0, 0), Vector3(0.05, 0, -1).normalized());
  CHECK(bench.locate().tip.at_end);
  bench.put_needle(on_line(0.02001) + Vector3(0, 0, 0));
  CHECK_FALSE(bench.locate().tip.at_end);
}

TEST_CASE("as a cut lays a vertex, what holds the needle across its path does not change") {
  // Before and after the vertex at 22 mm is laid: its share was the tip's.
  for (const bool laid : {false, true}) {
    CAPTURE(laid);
    InsertionBench bench;
    std::vector<Vector3> places{on_line(0.030), on_line(0.026)};
    if (laid) places.push_back(on_line(0.022));
    places.push_back(on_line(0.022));
    bench.add_path(places, 4e-3);
    bench.be_in_path(0);
    bench.put_needle(on_line(0.022));
    const Located& located = bench.locate();
    REQUIRE(located.shaft.size() == (laid ? 3 : 2));
    CHECK(located.shaft[0].supported == doctest::Approx(0.002).epsilon(1e-9));
    CHECK(located.shaft[1].supported == doctest::Approx(0.004).epsilon(1e-9));
    const double here = laid ? located.shaft[2].supported + located.tip.supported : located.tip.supported;
    CHECK(here == doctest::Approx(0.002).epsilon(1e-9));
  }
}

TEST_CASE("a tip back between two vertices is held to the point between them") {
  InsertionBench bench;
  const TipPlace& tip = place_at(bench, 0.023);  // u = 3/4
  CHECK_FALSE(tip.in_tail);
  CHECK_FALSE(tip.at_end);
  CHECK(tip.point.u == doctest::Approx(0.75).epsilon(1e-9));
  CHECK(tip.supported == doctest::Approx(0.0015).epsilon(1e-9));
  CHECK((bench.view().tissue.position(tip.point) - on_line(0.023)).norm() < kRounding);
}

TEST_CASE("a tip back between the last vertex and the end is held to the way between them") {
  InsertionBench bench;
  const TipPlace& tip = place_at(bench, 0.0215);  // u = 1/4
  CHECK(tip.in_tail);
  CHECK_FALSE(tip.at_end);
  CHECK(tip.point.u == doctest::Approx(0.25).epsilon(1e-9));
  CHECK(tip.supported == doctest::Approx(0.00025).epsilon(1e-9));
  CHECK(bench.scratch.located.shaft.back().supported == doctest::Approx(0.00225).epsilon(1e-9));
}

TEST_CASE("a tip before the mouth is held to the mouth") {
  InsertionBench bench;
  const TipPlace& tip = place_at(bench, 0.031);
  CHECK_FALSE(tip.at_end);
  CHECK(tip.point.u == 0);
  CHECK(tip.supported == 0);
  CHECK((bench.view().tissue.position(tip.point) - on_line(kTop)).norm() < kRounding);
  CHECK(bench.scratch.located.shaft.empty());
}

TEST_CASE("a path that has left the tissue has no end to cut at") {
  InsertionBench bench;
  bench.add_straight_path(kBottom).exited = true;
  bench.be_in_path(0);
  bench.put_needle(on_line(kBottom));
  CHECK_FALSE(bench.locate().tip.in_tail);
  CHECK_FALSE(bench.scratch.located.tip.at_end);
}

}  // namespace acus::test
