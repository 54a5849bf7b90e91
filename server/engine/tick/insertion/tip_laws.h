// SPDX-License-Identifier: GPL-3.0-or-later
// Laws of the tip: its local compliance (m/N, models/unresolved/local_compliance.h) and the friction of a sharp tip.
//
// Compliance ahead of a cutting tip, e. At the cutting force f_c the tip is e f_c ahead of its path's end in the mesh;
// the real end of the cut is between the two. On a border that holds tips it is ahead by its dimple's depth under the
// same force, D (models/unresolved/dimple.h). With y what the tip has still to go to where it is then, along the
// cutting direction,
//
//   e f_c = min(e f_c, D + y) where that is above D,   max(e f_c, D - y/2) where it is below.
//
// So the tip has the same force and the same place before and after its path's end has come to the border, and the end
// never moves back.
//
// Friction of a sharp tip on a surface. The needle is at the angle theta to the surface normal, its face at beta to its
// axis. The force of a slender needle acts along it: f cos theta along the normal, f sin theta across. A blunt tip
// slides where tan theta > mu, and so never punctures in a shallow insertion. A sharp tip slides only where its face
// lies flat on the surface, theta > pi/2 - beta; else its edge or point meets the surface first and sticks. The law is
//
//   mu' = max(mu, cot beta)      where theta < pi/2 - beta, else mu,
//
// and the tip punctures when the force along the needle is f_p, that is f_p cos theta along the normal. One goes over
// into the other, evenly by cos theta, from 2 degrees before that angle to 2 degrees beyond it. So a tip that comes to
// lie flat, as its needle bends, begins to slide smoothly; from tick to tick it would stick and slip.
//
// beta: face_angle().
#pragma once

#include <optional>

#include "server/engine/math/types.h"
#include "server/engine/scene/scene.h"
#include "server/engine/tick/insertion/insertion.h"

namespace acus {

// Of a tip at the end of its path, before a border.
double cutting_compliance(const InsertionView& at, const Path& path, const BorderAhead& border);
// Across the path, in the tissue at `material`: that of the tip's end and of its supported length (m) in parallel.
double tip_lateral_compliance(const InsertionView& at, const MaterialPoint& material, double supported);

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
