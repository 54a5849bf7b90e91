// SPDX-License-Identifier: GPL-3.0-or-later
// Growth of a path: cut by the tip, or along a border that holds the tip. All functions return flags.
#pragma once

#include "server/engine/tick/insertion/transitions/transition.h"

namespace acus {

// Moves the path's end to where the tip has cut: along the cutting direction through the material (path_direction.h),
// through every border that does not hold tips, to the first one that does. The end lies in tetrahedron `start`, or on
// its face towards `came_from`. `border`: that holds tips, before this one.
std::uint32_t grow(const Transition& now, Path& path, int start, int came_from, const BorderAhead& border = {});

// Moves the path's end along the border that holds the tip, with a vertex at every spacing of the straight line there.
// Vertices that the end passes on its way back are dropped: a tip dragged to and fro leaves one path.
std::uint32_t slide(const Transition& now, Path& path, const MaterialPoint& end);

// Adds the vertices of a straight piece of cut, each at its exact distance.
std::uint32_t lay_vertices(const Transition& now, Path& path, int start, const Vector3& from, const Vector3& to);

// The tip leaves the border that holds it, if any.
void leave_border(const Transition& now);

}  // namespace acus
