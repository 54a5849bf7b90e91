// SPDX-License-Identifier: GPL-3.0-or-later
// The tissue as it is drawn: skin under a tip, walls of paths, several needles; and that the place where a needle goes
// in does not depend on the mesh.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "server/engine/tick/drawn_tissue.h"
#include "tests/tick/bench.h"

namespace acus::test {
namespace {

constexpr double kSpeed = 0.02;  // m/s

DrawnTissue drawn_of(const Bench& bench) {
  DrawnTissue drawn(bench.simulation().model());
  draw_tissue(bench.simulation().model(), bench.simulation().state(), drawn);
  return drawn;
}

// Length of the drawn path from its mouth to the tip.
double drawn_depth(const Bench& bench) {
  const DrawnTissue drawn = drawn_of(bench);
  REQUIRE(drawn.path_sizes.size() == 1);
  return (drawn.path_points.col(0) - bench.needle().tip_position).norm();
}

// A soft block that a needle drags along, in so many cells.
Scene soft_block(int cells) {
  Scene scene = block_scene();
  scene.tissue.box.cells = {cells, cells, cells};
  scene.tissue.regions[0].material.young_modulus = 10e3;
  Interaction& law = scene.tissue.regions[0].interaction;
  law.pressure = 20e3;
  law.friction_dynamic = law.friction_static = 0.5;
  law.cutting_force = 0.3;
  law.puncture_force = 0.5;
  return scene;
}

}  // namespace

TEST_CASE("before anything touches there is nothing but the mesh") {
  Bench bench(block_scene());
  bench.wait(0.05);
  const DrawnTissue drawn = drawn_of(bench);
  CHECK(drawn.dents.empty());
  CHECK(drawn.path_sizes.empty());
  CHECK(drawn.points == 0);
}

TEST_CASE("a tip that presses is on the skin, which has one dent") {
  Bench bench(block_scene());
  while (bench.needle().phase != Phase::contact) bench.push(0, 2e-4, kSpeed);
  bench.push(0, 5e-4, kSpeed);
  REQUIRE(bench.needle().phase == Phase::contact);
  const DrawnTissue drawn = drawn_of(bench);
  REQUIRE(drawn.dents.size() == 1);
  CHECK(drawn.dents[0].move.z() < -1e-4);
  CHECK((drawn.dents[0].centre + drawn.dents[0].move - bench.needle().tip_position).norm() < 1e-12);
}

TEST_CASE("inside, the drawn path begins at the skin, touches the needle and ends at the tip" *
          doctest::test_suite("gate")) {
  Bench bench(block_scene());
  bench.push(0, 0.03, kSpeed);
  REQUIRE(bench.needle().phase == Phase::inside);
  const DrawnTissue drawn = drawn_of(bench);
  REQUIRE(drawn.path_sizes.size() == 1);
  REQUIRE(drawn.path_sizes[0] > 3);
  const Matrix3X path = drawn.path_points.leftCols(drawn.points);
  CHECK((path.rightCols<1>() - bench.needle().tip_position).norm() < 1e-6);
  const Vector3 tip = bench.needle().tip_position, along = bench.axis();
  for (int i = 0; i < drawn.points; ++i) {
    const Vector3 apart = path.col(i) - tip;
    CHECK((apart - apart.dot(along) * along).norm() < 1e-5);  // 2.5e-6: the needle is a little bent
    if (i > 0) CHECK((path.col(i) - path.col(i - 1)).dot(along) > 0);
  }
  CHECK((path.col(0) - tip).norm() == doctest::Approx(bench.needle().inserted_depth).epsilon(1e-3).scale(0));
  CHECK((path.col(0) - drawn.dents[0].centre - displacement(drawn.dents, drawn.dents[0].centre)).norm() < 2e-5);
}

TEST_CASE("depth and force do not depend on the mesh, however far the skin is dragged along" *
          doctest::test_suite("gate")) {
  double depth[2], force[2], on_mesh[2];
  const int cells[2] = {6, 12};
  for (int k = 0; k < 2; ++k) {
    Bench bench(soft_block(cells[k]));
    bench.push(0, 0.045, kSpeed);
    depth[k] = bench.needle().inserted_depth;
    force[k] = bench.resistance();
    CHECK(drawn_depth(bench) == doctest::Approx(depth[k]).epsilon(1e-3).scale(0));
    Matrix3X points(3, bench.simulation().path_capacity());
    bench.simulation().path_positions(0, points);
    on_mesh[k] = (points.col(0) - bench.needle().tip_position).norm();
  }
  CAPTURE(depth[0]);
  CAPTURE(force[0]);
  CAPTURE(on_mesh[0]);
  CAPTURE(on_mesh[1]);
  CHECK(depth[0] == doctest::Approx(depth[1]).epsilon(0.01).scale(0));
  CHECK(force[0] == doctest::Approx(force[1]).epsilon(0.01).scale(0));
  CHECK(on_mesh[0] - on_mesh[1] > 3 * std::abs(depth[0] - depth[1]));
}

TEST_CASE("while the skin sticks to a needle that is drawn back, the depth does not change" *
          doctest::test_suite("gate")) {
  Bench bench(soft_block(6));
  bench.push(0, 0.035, kSpeed);
  const double before = bench.needle().inserted_depth, pushed = bench.resistance();
  bench.push(0, -5e-4, kSpeed);
  REQUIRE(bench.resistance() < pushed - 0.1);
  CHECK(std::abs(bench.needle().inserted_depth - before) < 1e-4);
  bench.push(0, -0.015, kSpeed);
  CHECK(bench.needle().inserted_depth < before - 2e-3);
}

TEST_CASE(
    "a needle that is through passes through its drawn mouth and exit, and the depth has no step as it comes back" *
    doctest::test_suite("gate")) {
  Scene scene = soft_block(6);
  scene.tissue.box.size.z() = 0.02;
  scene.needles[0].base.position.z() -= 0.02;
  Bench bench(scene);
  bench.push(0, 0.04, kSpeed);
  REQUIRE(bench.needle().phase == Phase::through);
  const auto off_needle = [&](Eigen::Index point) {
    const Vector3 apart = drawn_of(bench).path_points.col(point) - bench.needle().tip_position;
    return (apart - apart.dot(bench.axis()) * bench.axis()).norm();
  };
  CHECK(off_needle(0) < 2e-5);  // 7e-6: the needle is a little bent
  CHECK(off_needle(drawn_of(bench).points - 1) < 2e-5);
  double before = bench.needle().inserted_depth, step = 0;
  bench.each_tick = [&] {
    step = std::max(step, std::abs(bench.needle().inserted_depth - before));
    before = bench.needle().inserted_depth;
  };
  bench.push(0, -0.03, kSpeed);
  REQUIRE(bench.events(EventKind::reentry).size() == 1);
  CHECK(step < 1e-3);
}

TEST_CASE("two tips side by side are both on the skin" * doctest::test_suite("gate")) {
  Scene scene = block_scene();
  scene.needles.push_back(scene.needles[0]);
  scene.needles[1].name = "beside";
  scene.needles[1].base.position.x() += 0.004;
  Bench bench(scene);
  double deepest = 0;
  bench.each_tick = [&] {
    if (bench.needle(0).phase == Phase::contact && bench.needle(1).phase == Phase::contact)
      for (const Dent& dent : drawn_of(bench).dents) deepest = std::max(deepest, dent.move.norm());
  };
  for (int i = 0; i < 40; ++i) {
    bench.push(0, 2e-4, kSpeed);
    bench.push(1, 2e-4, kSpeed);
  }
  CHECK(deepest > 1e-4);
}

}  // namespace acus::test
