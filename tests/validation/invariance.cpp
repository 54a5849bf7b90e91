// SPDX-License-Identifier: GPL-3.0-or-later
// Where the world stands must not matter, nor how often a run is repeated.
#include <doctest/doctest.h>

#include "server/engine/math/rotation.h"
#include "tests/validation/insertion_run.h"

namespace acus::test {

namespace {

const std::vector<Leg> kMotion{{0.045, 0.06, 0.05}, {0.03, 0.06, 0.05}, {0.055, 0.06}, {-0.005, 0.06}};

}  // namespace

TEST_CASE("a rotated and translated scene gives the rotated and translated answer") {
  Scene scene = coarse_scene();
  scene.gravity = {0, 0, -2};
  scene.laws.tolerance = 1e-11;
  scene.laws.max_steps = 20000;
  Scene moved = scene;
  const Pose shift{{0.3, -0.2, 0.5}, rotation_exp({0.7, -1.1, 0.4})};
  const auto place = [&](const Pose& p) { return Pose{shift * p.position, shift.orientation * p.orientation}; };
  moved.tissue.pose = place(scene.tissue.pose);
  moved.needles[0].base = place(scene.needles[0].base);
  moved.gravity = shift.orientation * scene.gravity;

  InsertionRun here(scene), there(moved);
  here.run(kMotion);
  there.run(kMotion);
  REQUIRE(here.samples().size() == there.samples().size());
  double peak = 0, force = 0, tip = 0, tissue = 0;
  for (std::size_t i = 0; i < here.samples().size(); ++i) {
    const NeedleReport& a = here.samples()[i].report.needles[0];
    const NeedleReport& b = there.samples()[i].report.needles[0];
    peak = std::max(peak, a.base_force.norm());
    force = std::max(force, (shift.orientation * a.base_force - b.base_force).norm());
    tip = std::max(tip, (shift * a.tip_position - b.tip_position).norm());
  }
  const Matrix3X at_end = there.simulation().tissue_positions();
  for (int i = 0; i < at_end.cols(); ++i)
    tissue = std::max(tissue, (shift * Vector3(here.simulation().tissue_positions().col(i)) - at_end.col(i)).norm());
  MESSAGE("relative difference of forces " << force / peak << ", tip " << tip << " m, tissue " << tissue << " m");
  CHECK(force < 2e-7 * peak);
  CHECK(tip < 2e-8 * scene.needles[0].length);
  CHECK(tissue < 1e-9 * 0.1);
}

TEST_CASE("the same commands give the same bytes, after a reset too") {
  const auto trace = [](InsertionRun& run, std::size_t from) {
    std::vector<double> values;
    for (std::size_t i = from; i < run.samples().size(); ++i) {
      const NeedleReport& n = run.samples()[i].report.needles[0];
      for (const Vector3& v : {n.base_force, n.base_torque, n.tip_position, n.friction_force})
        values.insert(values.end(), v.data(), v.data() + 3);
    }
    return values;
  };
  const Scene scene = coarse_scene();
  InsertionRun first(scene), second(scene);
  first.run(kMotion);
  second.run(kMotion);
  const std::vector<double> expected = trace(first, 0);
  CHECK(trace(second, 0) == expected);

  const std::size_t ticks = first.samples().size();
  first.simulation().reset();
  first.run({{0, 1}});  // the run's own idea of depth goes back to the start
  first.simulation().reset();
  const std::size_t from = first.samples().size();
  first.run(kMotion);
  CHECK(first.samples().size() - from <= ticks);
  CHECK(trace(first, from) == expected);
}

}  // namespace acus::test
