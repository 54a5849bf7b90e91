// SPDX-License-Identifier: GPL-3.0-or-later
// How much of what a hand feels is of the mesh: point forces meet elements, not tissue, and give way the less the
// larger those are. The same needles in the same block on four meshes, with and without the give that a mesh cannot
// resolve (tissue.local_compliance, local_compliance.h).
//
// The block: 60 mm, 30 kPa, held at all faces but the top. A rigid needle of 1 mm is pressed on it, punctures, is
// pushed 30 mm deep, pulled back a little and moved sideways; a flexible one of 0.4 mm with a tip that cuts at an angle
// is pushed 45 mm deep. Slow, without viscosity, ticks of 20 ms. Where friction is 30 N/m in tissue of 10 kPa, a rigid
// one drags the skin millimetres along.
//
// Base force in steady insertion is f_c and friction, which are laws of their own: it has to be the same on all meshes.
// Where the forces come up and how far the tissue gives way until then is what depends on the mesh.
#pragma once

#include <string>
#include <vector>

#include "server/engine/scene/scene.h"
#include "tests/study/studies/study.h"

namespace acus {

struct MeshRow {
  TissueElement element = TissueElement::linear;
  // With none there is a foundation of 10 MPa: on one of .inf a rigid needle and points of its path, closer than
  // elements tell apart, pull at each other with newtons.
  LocalCompliance give = LocalCompliance::none;
  double poisson_ratio = 0;
  int cells = 0;                 // across the block
  double indentation = 0;        // m, of the surface under 0.1 N
  double press_force = 0;        // N, at an indentation of 0.3 mm
  double puncture_depth = 0;     // m, indentation at which the surface gives way
  double base_force = 0;         // N, pushing, mean over the last 5 mm
  double base_peak = 0;          // N, largest of the whole way
  double axial_stiffness = 0;    // N/m, of a needle in friction that is pulled back by 20 um
  double lateral_stiffness = 0;  // N/m, of a needle 30 mm deep that is moved sideways by 0.1 mm
  double dragged_force = 0;      // N, of a needle that drags the skin along, base 35 to 40 mm past the surface
  double dragged_depth = 0;      // m, at the end of that
  double steering_radius = 0;    // m, of the flexible needle's way from 20 to 45 mm of depth
};

// All rows. The quick form has two meshes, one of Poisson's ratios and no steering, whose radius is then NaN.
std::vector<MeshRow> mesh_table(bool quick,
                                const std::function<void(int done, int of, const std::string& next)>& progress);

// Writes them to mesh_dependence.csv.
void study_mesh_dependence(const StudyPlan& plan);

}  // namespace acus
