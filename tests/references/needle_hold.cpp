// SPDX-License-Identifier: GPL-3.0-or-later
// How stiffly tissue holds a needle sideways, whatever the mesh and the spacing of constraint points.
//
// Source: needle_in_block.py, which meshes a block with the needle in it and has CalculiX solve it: a rigid needle of 1 mm,
// guided, 20, 40 and 70 mm deep in 100 mm of tissue of 10 kPa, goes aside by 0.1 mm.
#include "tests/references/figure.h"
#include "tests/references/soft_block.h"

namespace acus::test {
namespace {

constexpr double kEdge = 0.1, kAside = 1e-4, kClearance = 5e-4;  // m
constexpr double kRate = 50;                                     // Hz

Volume beyond(int axis, int side) {
  Volume volume;
  volume.box = Box{};
  (side < 0 ? volume.box->max : volume.box->min)[axis] = side * (kEdge / 2 - 1e-6);
  return volume;
}

Scene block(int cells, double spacing) {
  Scene scene = soft_block(kEdge, cells, kClearance);
  scene.rate = kRate;
  scene.tissue.rung = TissueRung::linear;
  scene.tissue.fixed = {beyond(0, -1), beyond(0, 1), beyond(1, -1), beyond(1, 1), beyond(2, -1)};
  Interaction& law = scene.tissue.regions[0].interaction;
  law = {.puncture_force = 0.02, .cutting_force = 0.01, .pressure = 0, .foundation_stiffness = {}};
  law.friction_contact = 0;
  scene.needles[0].constraint_spacing = spacing;
  return scene;
}

// Force over way (N/m) of a needle that far in.
double stiffness(int cells, double spacing, double depth) {
  Bench bench(block(cells, spacing));
  bench.push(0, depth + kClearance, 0.025);
  bench.wait(0.2);
  const double before = bench.needle().base_force.x();
  bench.move(0, {kAside, 0, 0}, kAside * kRate);
  bench.wait(0.4);
  CHECK(std::abs(bench.needle().inserted_depth - depth) < 1e-3);
  return (before - bench.needle().base_force.x()) / kAside;
}

struct Reference {
  double depth, stiffness;  // m, N/m
};

}  // namespace

TEST_CASE("tissue holds a needle sideways as a mesh does that has it in it") {
  for (const auto [depth, reference] : {Reference{0.02, 203.0}, {0.04, 384.4}, {0.07, 673.2}})
    for (const int cells : {8, 12})
      for (const double spacing : {1e-3, 8e-3}) {
        const std::string what = "needle " + std::to_string(static_cast<int>(1e3 * depth)) + " mm deep, " +
                                 std::to_string(cells) + " cells, spacing " +
                                 std::to_string(static_cast<int>(1e3 * spacing)) + " mm, sideways (N/m)";
        CHECK(agrees(what, reference, stiffness(cells, spacing, depth), 0.07 * reference));
      }
}

}  // namespace acus::test
