// SPDX-License-Identifier: GPL-3.0-or-later
// How a path gets longer: cut by the tip, or drawn along a border that holds it. All return flags.
#pragma once

#include "server/engine/tick/insertion/transition.h"

namespace acus {

// Moves the path's end to where the tip has cut: along its cutting direction through the material (material_direction.h),
// through every border that does not hold it, to the first one that does. The end lies in tetrahedron `start`, or on its
// face towards `came_from`; the tip is `ahead` (m) before a border that holds it (tip_compliance.h).
std::uint32_t grow(const Transition& now, Path& path, int start, int came_from, double ahead = kInfinity);

// Moves the path's end along the border that holds it, with a vertex at every spacing of the straight way there. Vertices
// that it comes back over are dropped: a tip that is dragged to and fro leaves one path, not one for every way.
std::uint32_t slide(const Transition& now, Path& path, const MaterialPoint& end);

// Sets the vertices that a straight piece of cut has passed, each at its exact distance.
std::uint32_t lay_vertices(const Transition& now, Path& path, int start, const Vector3& from, const Vector3& to);

// The tip does not rest against a border any more.
void leave_border(const Transition& now);

}  // namespace acus
