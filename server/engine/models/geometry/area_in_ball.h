// SPDX-License-Identifier: GPL-3.0-or-later
// How much of a triangle lies within a ball: what a place on a surface has around it, which changes without a jump as
// the place moves over edges and corners.
#pragma once

#include "server/engine/math/types.h"

namespace acus {

// m², of the triangle (a, b, c). 0 of one without an area.
double area_in_ball(const Vector3& a, const Vector3& b, const Vector3& c, const Vector3& centre, double radius);

}  // namespace acus
