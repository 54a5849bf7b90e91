// SPDX-License-Identifier: GPL-3.0-or-later
// Scenes with a needle above, or in, tissue so stiff that the needle's own mechanics and the laws are all there is.
#pragma once

#include "tests/tick/bench.h"

namespace acus::test {

// Bending and axial stiffness of a solid needle.
inline double bending_stiffness(const Needle& n) {
  return n.material.young_modulus * std::numbers::pi / 64 * std::pow(n.outer_diameter, 4);
}
inline double axial_stiffness(const Needle& n) {
  return n.material.young_modulus * std::numbers::pi / 4 * n.outer_diameter * n.outer_diameter;
}

// A block of 1 TPa with its top at z = 0 and one needle pointing down, 0.1 mm above it. The block gives way by 1e-11 m
// per newton.
inline Scene rigid_ground() {
  Scene scene;
  scene.rate = 500;
  scene.tissue.box = {{0.3, 0.3, 0.3}, {2, 2, 2}};
  scene.tissue.pose.position.z() = -0.15;
  scene.tissue.fixed.emplace_back().box = Box{Vector3::Constant(-kInfinity), {kInfinity, kInfinity, 0.01}};
  scene.tissue.regions[0].material.young_modulus = 1e12;
  scene.needles = {needle_at({0.011, 0.007, 0}, 1e-4)};
  return scene;
}

}  // namespace acus::test
