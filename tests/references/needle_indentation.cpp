// SPDX-License-Identifier: GPL-3.0-or-later
// How stiffly a surface bears a blunt needle that has not punctured it, whatever the puncture force and the mesh.
//
// Source: indentation.py, which has CalculiX press needles of 1 and 2 mm onto a neo-Hookean body of 10 kPa. Force over
// E a² depends on depth over a alone, a the needle's radius: the needle of 0.5 mm is that of 1 mm, half as large.
#include "tests/references/figure.h"
#include "tests/references/soft_block.h"

namespace acus::test {
namespace {

constexpr double kEdge = 0.08, kClearance = 1e-4;  // m
constexpr double kNeoHookean = 0.2;                // beta

Scene block(double diameter, double puncture_force, int cells) {
  Scene scene = soft_block(kEdge, cells, kClearance);
  scene.rate = 100;
  scene.tissue.fixed = {Volume{}};
  scene.tissue.fixed[0].box = Box{Vector3::Constant(-kInfinity), {kInfinity, kInfinity, -kEdge / 2 + 1e-6}};
  scene.tissue.regions[0].interaction.puncture_force = puncture_force;
  scene.tissue.regions[0].interaction.deep_indentation = kNeoHookean;
  scene.needles[0].outer_diameter = diameter;
  return scene;
}

struct Reference {
  double diameter, depth, force;  // m, m, N
};

}  // namespace

TEST_CASE("a surface bears blunt needles as a neo-Hookean body does, whatever the puncture force and the mesh") {
  for (const double puncture_force : {0.3, 3.0})
    for (const int cells : {5, 8})
      for (const double diameter : {0.5e-3, 1e-3, 2e-3}) {
        Bench bench(block(diameter, puncture_force, cells));
        double pushed = -kClearance;
        for (const auto& [d, depth, force] :
             {Reference{0.5e-3, 0.52e-3, 0.0110 / 4}, {0.5e-3, 1e-3, 0.0209 / 4}, {0.5e-3, 1.36e-3, 0.0300 / 4},
              {1e-3, 1.04e-3, 0.0110}, {1e-3, 2e-3, 0.0209}, {1e-3, 2.72e-3, 0.0300},
              {2e-3, 1.04e-3, 0.0229}, {2e-3, 2e-3, 0.0427}, {2e-3, 3.68e-3, 0.0780}}) {
          if (d != diameter) continue;
          bench.push(0, depth - pushed, 0.01);
          pushed = depth;
          bench.wait(0.05);
          const std::string what = "needle of " + std::to_string(1e3 * d) + " mm, " + std::to_string(1e3 * depth) +
                                   " mm deep, f_p " + std::to_string(puncture_force) + " N (N)";
          CHECK(agrees(what, force, bench.resistance(), 0.08 * force));
        }
      }
}

}  // namespace acus::test
