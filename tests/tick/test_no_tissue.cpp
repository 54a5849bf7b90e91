// SPDX-License-Identifier: GPL-3.0-or-later
// Scenes without tissue: needles and guides alone.
#include <doctest/doctest.h>

#include <numbers>

#include "tests/tick/bench.h"

namespace acus::test {

TEST_CASE("without tissue a needle moves as beside it") {
  Scene scene = block_scene();
  scene.gravity = {0, 0, -9.81};
  scene.needles[0].base.position += Vector3(0, 0, 0.1);
  Guide guide;
  guide.pose = {scene.needles[0].base * Vector3(0.06, 0, 0), scene.needles[0].base.orientation};
  guide.friction = 0.2;
  scene.guides = {guide};
  Bench beside(scene);
  scene.tissue.rung = TissueRung::none;
  Bench alone(scene);
  const auto move_both = [&](int body, const Vector3& by) {
    beside.move(body, by, 0.1);
    alone.move(body, by, 0.1);
    CHECK(alone.needle().base_force == beside.needle().base_force);
    CHECK(alone.needle().guide_force == beside.needle().guide_force);
    CHECK(alone.needle().tip_position == beside.needle().tip_position);
    CHECK(alone.simulation().report().rows == beside.simulation().report().rows);
  };
  move_both(0, {5e-3, 0, 0});
  move_both(1, {0, 3e-3, 0});
  move_both(0, {0, 0, -0.02});
  CHECK(alone.flags() == 0);
  CHECK(alone.needle().guide_force.norm() > 0.1);
}

TEST_CASE("without tissue there is no mesh, and nothing of it is read") {
  Scene scene = block_scene();
  scene.tissue.rung = TissueRung::none;
  scene.tissue.gmsh = GmshMesh{"no such file.msh", 1};
  scene.tissue.fixed.emplace_back().sphere = Sphere{{9, 9, 9}, 1e-3};
  Bench bench(scene);
  const Simulation& simulation = bench.simulation();
  CHECK(simulation.mesh().node_count() == 0);
  CHECK(simulation.tissue_positions().cols() == 0);
  CHECK(simulation.regions().empty());
  CHECK(simulation.costs().free_nodes == 0);
  CHECK(simulation.costs().factor_entries == 0);
  CHECK(simulation.costs().max_rows == 0);
  bench.push(0, 0.08, 0.1);
  CHECK(bench.needle().phase == Phase::free);
  CHECK(bench.needle().inserted_depth == 0);
  CHECK(simulation.report().events.empty());
  CHECK(simulation.report().imbalance < 1e-9);
}

TEST_CASE("without tissue a rigid needle weighs on its base") {
  Scene scene = block_scene();
  scene.tissue.rung = TissueRung::none;
  scene.gravity = {0, 0, -9.81};
  scene.needles[0].rung = NeedleRung::rigid;
  Bench bench(scene);
  bench.wait(0.1);
  const Needle& needle = scene.needles[0];
  const double volume = std::numbers::pi / 4 * needle.outer_diameter * needle.outer_diameter * needle.length;
  CHECK(bench.needle().base_force.z() ==
        doctest::Approx(-9.81 * needle.material.density * volume).epsilon(1e-9).scale(0));
}

}  // namespace acus::test
