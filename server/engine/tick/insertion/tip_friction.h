// SPDX-License-Identifier: GPL-3.0-or-later
// How a sharp tip holds on to a surface that it is pushed against aslant.
//
// Let the needle stand at the angle theta to the surface's normal, and its face at beta to its axis. The force of a
// slender needle acts along it, f (cos theta, sin theta) along and across the normal. A blunt tip slides where
// tan theta > mu, and so never punctures in a shallow insertion. A sharp one slides only where its face lies flat on the
// surface, theta > pi/2 - beta; else its edge, or its point, comes first and bites. Both say the same if it has the
// coefficient of friction
//
//   mu' = max(mu, cot beta)      where theta < pi/2 - beta, else mu,
//
// and it punctures when the force along the needle is f_p, that is f_p cos theta along the normal. Without tilt nothing
// changes.
//
// beta: hypodermic bevels 11 +- 2 degrees, short ones 17 +- 2 (ISO 7864:2016); pencil points are cones of some 15 degrees
// to a side, trocars have three faces at some 20. These two are typical values, no standard; a scene may give its own.
#pragma once

#include <optional>

#include "server/engine/math/types.h"
#include "server/engine/scene/scene.h"
#include "server/engine/tick/insertion/insertion.h"

namespace acus {

// Of a sharp tip (rad); none of a blunt one.
std::optional<double> face_angle(const Needle& needle);

struct TipFriction {
  double friction = 0;        // mu' (-)
  double puncture_share = 1;  // of f_p, along the normal
};

// Of a tip whose unit tangent is `along`, pushed against a surface with the unit normal `normal` towards it.
TipFriction tip_friction(const Needle& needle, const Vector3& along, const Vector3& normal, double friction);

// On an obstacle with these f_p (N) and mu, of the tip as it stands at the start of the tick; nothing bites into bone,
// whose f_p is infinite.
TipFriction tip_friction(const InsertionView& at, const Obstacle& obstacle, double puncture_force, double friction);

}  // namespace acus
