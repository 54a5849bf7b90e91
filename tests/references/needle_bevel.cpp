// SPDX-License-Identifier: GPL-3.0-or-later
// The arc along which a bevel steers its needle, from its geometry, the needle's stiffness and the tissue's.
//
// Source: bevel_in_body.py, a beam held by Kelvin's forces in an unbounded elastic body, whose edge cuts where it goes.
#include <numbers>
#include <vector>

#include "tests/references/figure.h"
#include "tests/references/rigid_ground.h"
#include "tests/study/studies/parabola.h"

namespace acus::test {
namespace {

constexpr double kBlock = 0.12, kFrom = 0.055, kTo = 0.094;  // m, depths at which the arc is measured
constexpr double kDegree = std::numbers::pi / 180;

struct Reference {
  double young_modulus, poisson_ratio;    // of the tissue (Pa, -)
  double diameter, needle_modulus, face;  // m, Pa, degrees
  double cutting_force;                   // N
  double radius;                          // m
};

double steered_radius(const Reference& of) {
  Scene scene;
  scene.rate = 250;
  scene.tissue.box = {Vector3::Constant(kBlock), {10, 10, 10}};
  scene.tissue.fixed.emplace_back().box = Box{Vector3::Constant(-kInfinity), {kInfinity, kInfinity, -kBlock / 2}};
  Region& region = scene.tissue.regions[0];
  region.material.young_modulus = of.young_modulus;
  region.material.poisson_ratio = of.poisson_ratio;
  region.interaction.cutting_force = of.cutting_force;
  region.interaction.puncture_force = of.cutting_force + 0.1;
  region.interaction.pressure = 500;
  scene.needles = {needle_at({2e-3, 0, kBlock / 2}, 1e-3)};
  Needle& needle = scene.needles[0];
  needle.length = 0.11;
  needle.base.position.z() += 0.01;
  needle.beams = 40;
  needle.outer_diameter = of.diameter;
  needle.material.young_modulus = of.needle_modulus;
  needle.tip = TipShape::bevel;
  needle.tip_angle = of.face * kDegree;
  needle.point_side = Vector3::UnitY();  // the world's, too
  Bench bench(scene);
  std::vector<double> depths, offsets;
  bench.each_tick = [&] {
    const Vector3& tip = bench.needle().tip_position;
    const double depth = kBlock / 2 - tip.z();
    if (depth < kFrom || depth > kTo) return;
    depths.push_back(depth);
    offsets.push_back(tip.y());
  };
  bench.push(0, 0.1, 0.04);
  CHECK((bench.flags() & ~kTangentProjected) == 0);
  return 1 / parabola_curvature(depths, offsets, (kFrom + kTo) / 2);
}

}  // namespace

TEST_CASE("a bevel steers its needle along the arc of a beam in an elastic body") {
  for (const Reference& of : {Reference{100e3, 0.45, 1e-3, 60e9, 11, 0, 0.4425},
                              {30e3, 0.4, 0.7e-3, 60e9, 20, 0, 0.4788},
                              {150e3, 0.45, 0.718e-3, 172e9, 17, 0, 0.3815},
                              {30e3, 0.45, 1e-3, 60e9, 11, 0.6, 0.8149}}) {
    const std::string what = "arc of a bevel, diameter " + std::to_string(1e3 * of.diameter) + " mm, face " +
                             std::to_string(of.face) + " degrees, f_c " + std::to_string(of.cutting_force) +
                             " N, radius (m)";
    CHECK(agrees(what, of.radius, steered_radius(of), 0.06 * of.radius));
  }
}

}  // namespace acus::test
