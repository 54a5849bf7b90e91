// SPDX-License-Identifier: GPL-3.0-or-later
// Needles that a bevel steers by its geometry (models/unresolved/bevel.h).
#include <doctest/doctest.h>

#include <numbers>

#include "tests/tick/bench.h"

namespace acus::test {
namespace {

Scene bevel_scene(const Vector3& side) {
  Scene scene = block_scene(0.08);
  scene.rate = 250;
  scene.tissue.regions[0].material.young_modulus = 60e3;
  scene.tissue.regions[0].interaction.pressure = 1e3;
  Needle& needle = scene.needles[0];
  needle.base.position.head<2>().setZero();
  needle.outer_diameter = 0.8e-3;
  needle.material.young_modulus = 60e9;
  needle.tip = TipShape::bevel;
  needle.point_side = side;
  return scene;
}

// The tip's place (m, world) at the end of an insertion by 70 mm.
Vector3 tip_of(const Scene& scene) {
  Bench bench(scene);
  bench.push(0, 0.07, 0.04);
  CHECK((bench.flags() & kNotFinite) == 0);
  return bench.needle().tip_position;
}

TEST_CASE("a bevel steers to the side of its point, whichever that is") {
  // The base's +y is the world's, its +z the world's +x. An exchange of x and y turns the mesh into itself.
  const Vector3 y = tip_of(bevel_scene({0, 1, 0})), x = tip_of(bevel_scene({7, 0, 2}));
  CHECK(y.y() > 3e-3);
  CHECK(x.x() > 3e-3);
  CHECK((Vector3(x.y(), x.x(), x.z()) - y).norm() < 0.02 * y.y());
  CHECK((tip_of(bevel_scene({0, -1, 0})) - Vector3(y.x(), -y.y(), y.z())).norm() < 0.05 * y.y());
}

TEST_CASE("what does not steer: a rigid needle, a point on the axis, tissue without strength, a bevel that is spun") {
  Scene rigid = bevel_scene({0, 1, 0});
  rigid.needles[0].rung = NeedleRung::rigid;
  CHECK(tip_of(rigid).head<2>().norm() < 1e-9);
  Scene pencil = bevel_scene({0, 1, 0});
  pencil.needles[0].point_offset = 0;
  CHECK(tip_of(pencil).head<2>().norm() < 0.1e-3);
  Scene weak = bevel_scene({0, 1, 0});
  weak.tissue.regions[0].interaction.tear_strength = 0.01;
  CHECK(tip_of(weak).head<2>().norm() < 0.3e-3);
  Scene spun = bevel_scene({0, 1, 0});
  Bench bench(spun);
  bench.screw(0, 0.07, 0.04, 40);
  CHECK(bench.needle().tip_position.head<2>().norm() < 0.5e-3);
}

TEST_CASE("each region has its own angle: stiff tissue below steers more than soft tissue does") {
  const auto layered = [](double below) {
    Scene scene = bevel_scene({0, 1, 0});
    Region lower = scene.tissue.regions[0];
    lower.name = "lower";
    lower.half_space = HalfSpace{Vector3(0, 0, 0.005), Vector3::UnitZ()};
    lower.material.young_modulus = below;
    lower.interaction.puncture_force = 0;
    scene.tissue.regions.push_back(lower);
    return scene;
  };
  const Scene scene = layered(600e3);
  const Simulation simulation(scene);
  const std::vector<Vector3>& cuts = simulation.model().cutting_directions[0];
  REQUIRE(cuts.size() == 2);
  for (const Vector3& cut : cuts) CHECK(cut.norm() == doctest::Approx(1));
  CHECK(cuts[1].y() > 1.3 * cuts[0].y());
  CHECK(cuts[0].z() == 0);
  CHECK(tip_of(scene).y() > 1.2 * tip_of(layered(60e3)).y());
}

TEST_CASE("a needle with a cutting direction cuts along it, everywhere") {
  Scene scene = bevel_scene({0, 1, 0});
  scene.needles[0].point_side.reset();
  scene.needles[0].cutting_direction = {2, 0.1, 0};
  const Simulation simulation(scene);
  CHECK(simulation.model().cutting_directions[0][0] == Vector3(2, 0.1, 0).normalized());
}

}  // namespace
}  // namespace acus::test
