// SPDX-License-Identifier: GPL-3.0-or-later
// Laws of the tip: its local compliance (m/N, models/unresolved/local_compliance.h) and the friction of a sharp tip.
//
// Compliance ahead of a cutting tip, e. At the cutting force f_c the tip is e f_c ahead of its path's end in the mesh.
// On a border that holds tips it is ahead by its dimple's depth D under the same force (models/unresolved/dimple.h).
// With y the way that the tip then has left along the cutting direction,
//
//   e f_c = min(e f_c, D + y) where that is above D,   max(e f_c, D - y/2) where it is below.
//
// In tissue that relaxes e f_c is what the tip is ahead by then (spring_memory.h).
//
// Force and place of the tip are then continuous as its path's end comes to the border, and the end never moves back.
//
// Friction of a sharp tip on a surface. The needle is at the angle theta to the normal, its face at beta (face_angle())
// to its axis. A blunt tip slides where tan theta > mu. A sharp tip slides only where its face lies flat on the
// surface, theta > pi/2 - beta, because otherwise its edge sticks:
//
//   mu' = max(mu, cot beta)      where theta < pi/2 - beta, else mu,
//
// and it punctures when the force along the needle is f_p, f_p cos theta along the normal. Within 2 degrees of
// pi/2 - beta the law changes evenly with cos theta.
#pragma once

#include <optional>

#include "server/engine/math/types.h"
#include "server/engine/scene/scene.h"
#include "server/engine/tick/insertion/insertion.h"

namespace acus {

// Ahead of a tip at the end of its path, before a border; `creep`: of its cut.
struct CutSpring {
  double compliance = 0;  // m/N
  double crept = 0;       // m

  // How far the tip is ahead of its path's end (m) with the force f (N).
  double lead(double f) const { return compliance * f + crept; }
};
CutSpring cut_spring(const InsertionView& at, const MaterialPoint& end, const Creep& creep, const BorderAhead& border);
// Across the path, in the tissue at `material`: that of the tip's end and of its supported length (m) in parallel.
double tip_lateral_compliance(const InsertionView& at, const MaterialPoint& material, double supported);
// The length of shaft (m) beside which the tissue is as stiff as around the tip's end.
double end_length(const InsertionView& at, const MaterialPoint& material);

struct TipFriction {
  double friction = 0;        // mu' (-)
  double puncture_share = 1;  // of f_p, along the normal
};

// `along`: unit tangent of the needle at the tip. `normal`: of the surface, unit, towards the tip.
TipFriction tip_friction(const Needle& needle, const Vector3& along, const Vector3& normal, double friction);

// The force along the needle whose part along the normal a tip bears, as it punctures an obstacle with f_p (N).
double force_along_needle(const InsertionView& at, const Obstacle& obstacle, double puncture_force, double contact);

// Against an obstacle with f_p (N) and mu, of the tip at the start of the tick. Bone, whose f_p is infinite, has mu' =
// mu.
TipFriction tip_friction(const InsertionView& at, const Obstacle& obstacle, double puncture_force, double friction);

}  // namespace acus
