// SPDX-License-Identifier: GPL-3.0-or-later
// Stage 4 of an insertion, once a tick: the surface or the border that the tip meets, which path vertices stand alongside
// the shaft and how much of it each owns, and where the tip stands in its path.
//
// Owned length. From halfway to the neighbour on one side to halfway on the other, the first from the surface, the last
// to the tip. The lengths sum to the inserted length at every moment, so that the friction of the whole shaft depends
// neither on the spacing of vertices nor on the moment when one comes or goes.
//
// Held length. Across the path each point of the needle is held by what its length of tissue bears, and its end like a
// sphere (local_compliance.h). Vertices have the lengths that they own, but the way between the last one and the tip is
// shared out in halves: a vertex that the cut lays at the tip takes over the tip's half at the tip's place, and gives it
// back as the needle is pulled out past it. So nothing jumps, and nothing depends on the spacing in the limit.
//
// A tip that is back inside its path lies between the last vertex alongside the shaft, A, and the next one ahead, B (or
// the path's end). It is held to (1 - u) A + u B, u the fraction of the way. Held to the closest point of the polyline
// instead, it would bear spikes where it passes B, whose offset would close within a tick. tests/validation/
// insertion_force.cpp holds that friction and lateral force are smooth past vertices, both ways.
//
// A tip that cuts is held to the path's end across its cutting direction, which is fixed in the tip's frame, and the end
// goes along this direction through the material (path_growth.h): that is what steers a bevel. The tip stands beside the
// end by what the tissue gives way under the force that bends the needle. If the end went to the tip instead, that force
// would have to build up anew from every step, over a way that grows with the give: a bevel would hardly steer.
#pragma once

#include <span>

#include "server/engine/tick/insertion/insertion.h"

namespace acus {

// Starts a needle's tick from what it remembers. `paths_taken`: per path, whether a needle has picked it up in this tick;
// this one may pick up another.
void locate_insertion(const InsertionView& at, const Insertion& before, std::span<const Path> paths,
                      std::span<char> paths_taken, InsertionWork& work);

// Lets the vertices alongside share the needle up to `end` (m). Returns what a tip that is held has of it (m).
double share_length(std::span<ShaftPoint> shaft, double end, bool tip_holds = true);

}  // namespace acus
