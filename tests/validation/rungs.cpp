// SPDX-License-Identifier: GPL-3.0-or-later
// The fast rung against the reference.
#include <doctest/doctest.h>

#include "tests/validation/insertion_run.h"

namespace acus::test {

TEST_CASE("rung warped follows rung exact") {
  const std::vector<Leg> motion{{0.05, 0.04, 0.1}, {0.03, 0.04, 0.1}, {0.055, 0.04, 0.1}, {-0.005, 0.04, 0.1}};
  Scene scene = coarse_scene();
  scene.laws.tolerance = 1e-8;
  scene.laws.max_sweeps = 20000;
  InsertionRun warped(scene);
  warped.run(motion);
  scene.tissue.rung = TissueRung::exact;
  scene.newton.tolerance = 1e-10;
  InsertionRun exact(scene);
  exact.run(motion);
  REQUIRE(warped.samples().size() == exact.samples().size());

  const auto puncture_tick = [](const InsertionRun& run) {
    const Event* e = run.find(EventKind::puncture);
    return e == nullptr ? std::uint64_t{0} : e->tick;
  };
  const std::uint64_t first = std::min(puncture_tick(warped), puncture_tick(exact));
  const std::uint64_t last = std::max(puncture_tick(warped), puncture_tick(exact));
  REQUIRE(first > 0);
  MESSAGE("punctures at ticks " << puncture_tick(warped) << " and " << puncture_tick(exact));
  CHECK(last - first <= 4);

  // Between the two punctures one needle is through and the other is not: the drop from f_p to f_c falls into different
  // ticks, and no bound on the difference there says anything.
  double peak = 0, force = 0, tip = 0;
  for (std::size_t i = 0; i < exact.samples().size(); ++i) {
    const NeedleReport& a = warped.samples()[i].report.needles[0];
    const NeedleReport& b = exact.samples()[i].report.needles[0];
    const std::uint64_t tick = exact.samples()[i].report.tick;
    peak = std::max(peak, b.base_force.norm());
    tip = std::max(tip, (a.tip_position - b.tip_position).norm());
    if (tick < first || tick > last) force = std::max(force, (a.base_force - b.base_force).norm());
  }
  MESSAGE("base force differs by " << 100 * force / peak << " % of its peak, tip by " << 1e3 * tip << " mm");
  CHECK(force < 0.02 * peak);
  CHECK(tip < 1e-4);
}

}  // namespace acus::test
