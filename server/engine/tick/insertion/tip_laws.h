// SPDX-License-Identifier: GPL-3.0-or-later
// Laws of the tip: its local compliance (m/N, models/local_compliance.h) and the friction of a sharp tip.
//
// Compliance ahead of a cutting tip, e. At the cutting force f_c the tip lags e f_c behind its path's end in the mesh;
// the real end of the cut is between the two. Near a border that holds tips, only the tissue before the border can
// yield: with D the tip's distance from the border along the cutting direction, e = min(e, D/f_c). So tip and path's
// end reach the border together.
//
// Friction of a sharp tip on a surface. The needle is at the angle theta to the surface normal, its face at beta to its
// axis. The force of a slender needle acts along it: f cos theta along the normal, f sin theta across. A blunt tip
// slides where tan theta > mu, and so never punctures in a shallow insertion. A sharp tip slides only where its face
// lies flat on the surface, theta > pi/2 - beta; else its edge or point meets the surface first and sticks. The law is
//
//   mu' = max(mu, cot beta)      where theta < pi/2 - beta, else mu,
//
// and the tip punctures when the force along the needle is f_p, that is f_p cos theta along the normal.
//
// beta: hypodermic bevels 11 +- 2 degrees, short ones 17 +- 2 (ISO 7864:2016). Pencil points are cones of about 15
// degrees half angle, trocars have three faces at about 20; these are typical values, no standard. A scene may give its
// own.
#pragma once

#include <optional>

#include "server/engine/math/types.h"
#include "server/engine/scene/scene.h"
#include "server/engine/tick/insertion/insertion.h"

namespace acus {

// Of a tip at the end of its path, `ahead` (m) before a border.
double cutting_compliance(const InsertionView& at, const Path& path, double ahead);
// Across the path, in the tissue at `material`: that of the tip's end and of its supported length (m) in parallel.
double tip_lateral_compliance(const InsertionView& at, const MaterialPoint& material, double supported);

// Distance (m) from a tip to an obstacle at `place` along the cutting direction; infinite if that leads away from it.
double distance_ahead(const InsertionView& at, const Obstacle& obstacle, const Vector3& tip, const Vector3& place);

// beta (rad); none for a blunt tip.
std::optional<double> face_angle(const Needle& needle);

struct TipFriction {
  double friction = 0;        // mu' (-)
  double puncture_share = 1;  // of f_p, along the normal
};

// `along`: unit tangent of the needle at the tip. `normal`: of the surface, unit, towards the tip.
TipFriction tip_friction(const Needle& needle, const Vector3& along, const Vector3& normal, double friction);

// Against an obstacle with f_p (N) and mu, of the tip at the start of the tick. Bone, whose f_p is infinite, has mu' =
// mu.
TipFriction tip_friction(const InsertionView& at, const Obstacle& obstacle, double puncture_force, double friction);

}  // namespace acus
