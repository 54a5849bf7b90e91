// SPDX-License-Identifier: GPL-3.0-or-later
// The lengths of shaft that path vertices stand for.
//
// Owned length, for friction: from halfway to one neighbour to halfway to the other; the first vertex's begins at the
// surface, the last one's ends at the tip. Those of a part of the path are scaled so that they sum to its length from
// wall to wall, or to the tip (path_wall.h, with the forces of the last tick), at every moment: the friction of the
// shaft depends neither on the mesh nor on the spacing of vertices, nor on when one is added or passed. In layers all
// are scaled alike, although those behind the first keep their tissue.
//
// Supported length, for the lateral rows: the owned length without that scale, but the stretch between the last
// vertex and the tip is split in halves between the two. A vertex that the cut adds at the tip takes over the tip's
// half there, and the tip takes it back as it is pulled past the vertex. So the lateral force has no jumps and
// converges as the spacing shrinks. The tip's end adds the support of a sphere (models/unresolved/local_compliance.h).
#pragma once

#include <span>

#include "server/engine/tick/insertion/insertion.h"

namespace acus {

// Sets owned and supported lengths of the vertices alongside, which share the needle up to `end` (m), in the mesh.
// Returns the supported length of the tip (m), 0 without tip_supports.
double share_length(std::span<ShaftPoint> shaft, double end, bool tip_supports = true);

// Scales the owned lengths. `shaft` has the advances of mouths and exits, `end` is that of share_length().
void scale_owned_lengths(const InsertionView& at, const Path& path, const Insertion& state, std::span<ShaftPoint> shaft,
                         double end);

}  // namespace acus
