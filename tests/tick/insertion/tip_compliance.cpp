// SPDX-License-Identifier: GPL-3.0-or-later
// What gives way under a tip that the mesh does not resolve.
#include <doctest/doctest.h>

#include "server/engine/tick/insertion/finding/obstacle.h"
#include "server/engine/tick/insertion/tip_laws.h"
#include "tests/tick/insertion/bench_insertion.h"

namespace acus::test {

TEST_CASE("ahead of a cutting tip gives way what the mesh does not, and on a border as much as its dimple") {
  InsertionBench bench;
  const Path& path = bench.add_straight_path(0.020);
  const double f_c = 0.2, give = bench.give();
  const auto lead = [&](double distance, double dimple) {
    return cut_spring(bench.view(), path.end, {}, {distance, dimple}).lead(f_c);
  };
  const double free = cut_spring(bench.view(), path.end, {}, {}).compliance;
  CHECK(free * f_c == doctest::Approx(give).epsilon(1e-12));
  CHECK(free > 0);
  for (const double dimple : {0.0, give / 3, give, 2 * give}) {
    CAPTURE(dimple);
    CHECK(lead(10 * give, dimple) == doctest::Approx(give).epsilon(1e-12));
    CHECK(lead(-dimple, dimple) == doctest::Approx(dimple).epsilon(1e-12));
    CHECK(lead(-dimple - 1e-3, dimple) == doctest::Approx(dimple).epsilon(1e-12));  // beyond it
    // On the way there the path's end never moves back.
    for (double before = 5 * give; before > -dimple; before -= give / 50)
      CHECK(before - give / 50 + lead(before - give / 50, dimple) <= before + lead(before, dimple) + 1e-12);
  }
  CHECK(lead(give / 4, 0) == doctest::Approx(give / 4).epsilon(1e-12));
}

TEST_CASE("a tissue that is cut without force has no limit to share out") {
  Scene scene = one_region();
  scene.tissue.regions[0].interaction.cutting_force = 0;
  InsertionBench bench(scene);
  const Path& path = bench.add_straight_path(0.020);
  CHECK(cut_spring(bench.view(), path.end, {}, {0, 0}).compliance ==
        cut_spring(bench.view(), path.end, {}, {}).compliance);
}

TEST_CASE("a scene may leave all springs inside out") {
  Scene scene = one_region();
  scene.tissue.local_compliance = LocalCompliance::none;
  InsertionBench bench(scene);
  const TissueView tissue = bench.view().tissue;
  const MaterialPoint p = bench.point(on_line(0.01));
  CHECK(tissue.tip_compliance(p, kDiameter, 0.2) == 0);
  CHECK(tissue.axial_compliance(p, kDiameter) == 0);
  CHECK(tissue.lateral_compliance(p, kDiameter) == doctest::Approx(1 / 50e3).epsilon(1e-12));  // is given
}

TEST_CASE("the way to a border is that along the cutting direction") {
  InsertionBench bench(two_regions(0.7));
  bench.add_straight_path(2e-4);
  bench.be_in_path(0);
  bench.put_needle(on_line(2e-4));
  REQUIRE(bench.locate().obstacle);
  CHECK(bench.scratch.located.tip.ahead.distance == doctest::Approx(2e-4).epsilon(1e-9));
  const Obstacle border = *bench.scratch.located.obstacle;
  const auto ahead = [&](const Vector3& direction) {
    bench.put_needle(on_line(2e-4), direction.normalized());
    return border_on_the_way(bench.view(), bench.paths[0], border, 2e-4);
  };
  CHECK(ahead({0, 0, -1}).dimple == doctest::Approx(border.dimple.depth(0.2)).epsilon(1e-9));  // f_c
  CHECK(ahead({1, 0, -1}).distance == doctest::Approx(2e-4 * std::sqrt(2)).epsilon(1e-9));
  CHECK(ahead({1, 0, -1}).dimple ==
        doctest::Approx(std::sqrt(2) * border.dimple.depth(0.2 / std::sqrt(2))).epsilon(1e-9));
  CHECK(ahead({1, 0, 0}).distance == kInfinity);
  CHECK(ahead({0, 0, 1}).distance == kInfinity);
}

}  // namespace acus::test
