// SPDX-License-Identifier: GPL-3.0-or-later
// The tissue of the references that CalculiX solves, as a scene: a cube of 10 kPa, nu = 0.45, held nowhere yet, and a
// rigid needle that points down at its top, beside the nodes.
#pragma once

#include "tests/tick/bench.h"

namespace acus::test {

inline Scene soft_block(double edge, int cells, double clearance) {
  Scene scene;
  scene.tissue.box = {Vector3::Constant(edge), {cells, cells, cells}};
  Material& material = scene.tissue.regions[0].material;
  material.young_modulus = 10e3;
  material.poisson_ratio = 0.45;
  material.rayleigh_stiffness = 0;
  Needle needle = needle_at({1.3e-3, 2.1e-3, edge / 2}, clearance);
  needle.rung = NeedleRung::rigid;
  needle.smoothing = 0;
  scene.needles = {needle};
  return scene;
}

}  // namespace acus::test
