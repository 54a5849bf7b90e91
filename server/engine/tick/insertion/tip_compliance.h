// SPDX-License-Identifier: GPL-3.0-or-later
// What gives way under a tip that the mesh does not resolve (m/N); local_compliance.h has the laws.
//
// Ahead of a cutting tip. The tip stands e f_c before its path's end, e the compliance of the tissue ahead of it, whose
// real place is between the two. Ahead of a border that holds the tip, only what lies between tip and border is left to
// give way: with D the tip's distance from it along the cutting direction, e = D/f_c where that is less. So tip and
// path's end come to the border together.
#pragma once

#include "server/engine/tick/insertion/insertion.h"

namespace acus {

// At the end of its path, `ahead` (m) before the border ahead.
double cutting_compliance(const InsertionView& at, const Path& path, double ahead);
// Across its way, in the tissue at `material`: of its end, and of `held` (m) of shaft that it stands for beside it.
double hold_compliance(const InsertionView& at, const MaterialPoint& material, double held);

// From a tip to an obstacle at `place` along the cutting direction (m), infinite if that leads away from it.
double distance_ahead(const InsertionView& at, const Obstacle& obstacle, const Vector3& tip, const Vector3& place);

}  // namespace acus
