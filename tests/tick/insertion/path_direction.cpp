// SPDX-License-Identifier: GPL-3.0-or-later
// The direction in the tissue at rest that a tip cuts along: turned with the tissue, blind to what the needle shears.
#include <doctest/doctest.h>

#include "server/engine/math/rotation.h"
#include "server/engine/tick/insertion/path_direction.h"
#include "tests/tick/insertion/bench_insertion.h"

namespace acus::test {
namespace {

constexpr double kWay = 2e-3;  // m
const Vector3 kDown = Vector3(0.1, 0, -1).normalized();

}  // namespace

TEST_CASE("in tissue at rest a direction is itself") {
  const InsertionBench bench;
  const MaterialPoint place = bench.point(on_line(0.01));
  CHECK((direction_at_rest(bench.view().tissue, place, kDown) - kDown).norm() < kRounding);
  const Vector3 way = way_through_material(bench.view().tissue, place, kDown, kWay);
  CHECK((way - kWay * kDown).norm() < kRounding);
}

TEST_CASE("tissue that is turned turns the direction with it") {
  InsertionBench bench;
  const Matrix3 turn = rotation_exp({0.3, -0.5, 0.2}).toRotationMatrix();
  for (const double z : {kTop, 0.01, -0.02}) {  // on the surface, too
    const MaterialPoint place = bench.point(on_line(z));
    bench.x = turn * bench.mesh.nodes;
    const TissueView tissue = bench.view().tissue;
    CHECK((direction_at_rest(tissue, place, turn * kDown) - kDown).norm() < 4e-3);  // by 35 degrees
    CHECK((way_through_material(tissue, place, turn * kDown, kWay) - kWay * turn * kDown).norm() < 4e-3 * kWay);
  }
}

TEST_CASE("tissue that the needle carries aside, most at its way, leaves the direction as it is") {
  InsertionBench bench;
  const Vector3 tip = on_line(0.01);
  const MaterialPoint place = bench.point(tip);
  for (int i = 0; i < bench.mesh.node_count(); ++i) {  // 2 mm at the tip, less all around it
    const double r = (bench.mesh.nodes.col(i) - tip).norm() / 0.015;
    bench.x.col(i) += Vector3(2e-3, 0, 0) / (1 + r * r);
  }
  const Vector3 straight = -Vector3::UnitZ();
  CHECK((direction_at_rest(bench.view().tissue, place, straight) - straight).norm() < 0.02);
  // The material line itself leans: the path follows it.
  const Vector3 way = way_through_material(bench.view().tissue, place, straight, kWay);
  CHECK(way.dot(straight) == doctest::Approx(kWay).epsilon(1e-9));
}

TEST_CASE("a way is as long along the direction as it is asked for, however the tissue is stretched") {
  InsertionBench bench;
  bench.x = Vector3(1.2, 0.9, 0.6).asDiagonal() * bench.mesh.nodes;
  const Vector3 way = way_through_material(bench.view().tissue, bench.point(on_line(0.01)), kDown, kWay);
  CHECK(way.dot(kDown) == doctest::Approx(kWay).epsilon(1e-9));
}

TEST_CASE("tissue that is pressed flat is gone through straight") {
  InsertionBench bench;
  bench.x.row(2).setZero();
  const Vector3 way = way_through_material(bench.view().tissue, bench.point(on_line(0.01)), kDown, kWay);
  CHECK(way == kWay * kDown);
}

}  // namespace acus::test
