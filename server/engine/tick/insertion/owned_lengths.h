// SPDX-License-Identifier: GPL-3.0-or-later
// The lengths of shaft that path vertices stand for.
//
// Owned length, for friction: from halfway to one neighbour to halfway to the other, the first from the surface, the
// last to the tip. Those of a part of the path are scaled to sum to its length from wall to wall, or to the tip
// (path_wall.h): friction depends neither on the mesh nor on the spacing of vertices. In layers all are scaled alike.
//
// Supported length, for the rows across: the owned length without the scale, but the tip has half of the stretch behind
// it. A vertex that the cut adds at the tip takes over the tip's half, and gives it back as the tip is pulled past it:
// the lateral force is continuous, and converges as the spacing shrinks.
//
// Tearing length, of the path whose strength a place has: the supported one, at the tip with the length of shaft that
// is as stiff as its end; all are scaled to sum to the supported ones. So a path of one strength bears that times its
// length.
#pragma once

#include <span>

#include "server/engine/tick/insertion/insertion.h"

namespace acus {

// Sets owned and supported lengths of the vertices alongside, which share the needle up to `end` (m), in the mesh.
// Returns the supported length of the tip (m), 0 without tip_supports.
double share_length(std::span<ShaftPoint> shaft, double end, bool tip_supports = true);

// Sets the tearing lengths; `end` (m): of the shaft that is as stiff as the end of the tip, 0 where that is through.
void share_tearing(std::span<ShaftPoint> shaft, TipPlace& tip, double end);

// Scales the owned lengths. `shaft` has the advances of mouths and exits, `end` is that of share_length().
void scale_owned_lengths(const InsertionView& at, const Path& path, const Insertion& state, std::span<ShaftPoint> shaft,
                         double end);

}  // namespace acus
