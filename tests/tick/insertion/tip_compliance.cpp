// SPDX-License-Identifier: GPL-3.0-or-later
// What gives way under a tip that the mesh does not resolve.
#include <doctest/doctest.h>

#include "server/engine/tick/insertion/tip_laws.h"
#include "tests/tick/insertion/bench_insertion.h"

namespace acus::test {

TEST_CASE("ahead of a cutting tip gives way what the mesh does not, before a border no more than lies between") {
  InsertionBench bench;
  const Path& path = bench.add_straight_path(0.020);
  const double f_c = 0.2;
  const double free = cutting_compliance(bench.view(), path, kInfinity);
  CHECK(free * f_c == doctest::Approx(bench.give()).epsilon(1e-12));
  CHECK(free > 0);
  CHECK(cutting_compliance(bench.view(), path, 2 * bench.give()) == free);
  CHECK(cutting_compliance(bench.view(), path, bench.give() / 4) == doctest::Approx(free / 4).epsilon(1e-12));
  CHECK(cutting_compliance(bench.view(), path, 0) == 0);
  CHECK(cutting_compliance(bench.view(), path, -1e-3) == 0);  // beyond it
}

TEST_CASE("a tissue that is cut without force has no limit to share out") {
  Scene scene = one_region();
  scene.tissue.regions[0].interaction.cutting_force = 0;
  InsertionBench bench(scene);
  const Path& path = bench.add_straight_path(0.020);
  CHECK(cutting_compliance(bench.view(), path, 0) == cutting_compliance(bench.view(), path, kInfinity));
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
  Vector3 along = -Vector3::UnitZ();
  bench.put_needle(on_line(2e-4), along);
  REQUIRE(bench.locate().obstacle);
  CHECK(bench.scratch.located.tip.ahead == doctest::Approx(2e-4).epsilon(1e-9));
  const Obstacle obstacle = *bench.scratch.located.obstacle;
  const auto ahead = [&](const Vector3& direction) {
    bench.put_needle(on_line(2e-4), direction.normalized());
    return distance_ahead(bench.view(), obstacle, on_line(2e-4), on_line(0));
  };
  CHECK(ahead({1, 0, -1}) == doctest::Approx(2e-4 * std::sqrt(2)).epsilon(1e-9));
  CHECK(ahead({1, 0, 0}) == kInfinity);
  CHECK(ahead({0, 0, 1}) == kInfinity);
}

}  // namespace acus::test
