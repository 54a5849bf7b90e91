// SPDX-License-Identifier: GPL-3.0-or-later
// A needle in a path that another one has cut with a smaller spacing: 8 mm and 1 mm.
#include <doctest/doctest.h>

#include <cmath>

#include "server/engine/tick/scratch.h"
#include "tests/tick/insertion/bench_insertion.h"

namespace acus::test {
namespace {

constexpr double kCoarse = 8e-3, kFine = 1e-3;

Scene coarse_and_fine() {
  Scene scene = one_region();
  scene.tissue.box.cells = {3, 3, 3};
  scene.tissue.fixed.emplace_back().half_space = HalfSpace{Vector3(0, 0, kBottom), Vector3::UnitZ()};
  Needle& coarse = scene.needles[0];
  coarse.constraint_spacing = kCoarse;
  coarse.base.position = {0, 0, 0.2};
  Needle fine = coarse;
  fine.name = "fine";
  fine.constraint_spacing = kFine;
  scene.needles.push_back(fine);
  scene.needle_contact.enabled = false;  // one stands in the other
  return scene;
}

}  // namespace

TEST_CASE("a scene has room for every vertex of its finest path alongside its coarsest needle") {
  const Scene scene = coarse_and_fine();
  const Model model(scene);
  const Scratch scratch(model);
  const std::size_t points = 100;  // 0.1 m of needle in a path of 1 mm
  CHECK(scratch.insertions[0].located.shaft.capacity() >= points);
  CHECK(scratch.insertions[1].located.shaft.capacity() >= points);
  CHECK(model.max_rows >= static_cast<int>(2 * 3 * points));
}

TEST_CASE("room for tissue squeezed to two thirds of its length is there for one needle, not for eight at once") {
  Scene scene = coarse_and_fine();
  scene.needles.resize(1);
  const int vertices = 4 + static_cast<int>(std::ceil(scene.needles[0].length / kCoarse));
  const int one = Model(scene).max_rows;
  CHECK(one >= 3 * 3 * (vertices - 4) / 2);
  for (int i = 1; i < 8; ++i) {
    scene.needles.push_back(scene.needles[0]);
    scene.needles.back().name = std::to_string(i);
    scene.needles.back().base.position.x() = 5e-3 * i;
  }
  const int eight = Model(scene).max_rows;
  CHECK(eight >= 8 * 3 * vertices + 3 * (vertices - 4) / 2);
  CHECK(eight < 7 * one);
}

TEST_CASE("a needle holds to every vertex of a path with a smaller spacing") {
  InsertionBench bench(coarse_and_fine());
  bench.add_straight_path(-0.0205, kFine);
  bench.be_in_path(0);
  bench.put_needle(on_line(-0.0205));
  const Located& located = bench.locate();
  CHECK_FALSE(located.left_out);
  REQUIRE(located.shaft.size() == 51);
  CHECK(located.shaft[0].owned == doctest::Approx(0.5e-3).epsilon(1e-9));
  CHECK(located.shaft[1].owned == doctest::Approx(1e-3).epsilon(1e-9));
}

TEST_CASE("how young a path is depends on its own spacing, not on the needle's") {
  InsertionBench bench(coarse_and_fine());
  const Vector3 tilted = Vector3(0.3, 0, -1).normalized();
  const Vector3 mouth = on_line(kTop);
  // Full spacings long: it has a direction of its own.
  bench.add_path({mouth, mouth + kFine * tilted, mouth + 2 * kFine * tilted, mouth + 2.6 * kFine * tilted}, kFine);
  bench.be_in_path(0);
  bench.put_needle(mouth - Vector3(0, 0, 2.6 * kFine));
  const Located& located = bench.locate();
  REQUIRE(located.shaft.size() == 3);
  for (const ShaftPoint& point : located.shaft) CHECK((point.tangent - tilted).norm() < 1e-9);
}

}  // namespace acus::test
