// SPDX-License-Identifier: GPL-3.0-or-later
// Stage 4 of an insertion, once a tick: the surface or border ahead of the tip, the path vertices alongside the shaft
// with their lengths (owned_lengths.h), and the place of the tip in its path.
//
// A tip back inside its path is between the last vertex alongside the shaft, A, and the next one ahead, B (or the
// path's end). Its lateral rows act against (1 - u) A + u B, u the fraction of the distance. Rows against the closest
// point of the polyline would have spikes at B, where the offset would close within a tick.
// tests/validation/insertion_force.cpp checks that friction and lateral force are smooth past vertices, both ways.
//
// A tip that cuts has lateral rows against the path's end, across its cutting direction, which is fixed in the tip's
// frame. The end moves along this direction through the material (path_growth.h), and so a bevel steers. The tip is
// beside the end by the lateral compliance under the force that bends the needle. If the end moved to the tip instead,
// this force would build up anew in every step, and a bevel would hardly steer.
#pragma once

#include <span>

#include "server/engine/tick/insertion/insertion.h"

namespace acus {

// Starts a needle's tick from its state `before`. `paths_taken`: per path, whether a needle has entered it in this
// tick; this one may enter another.
void locate_insertion(const InsertionView& at, const Insertion& before, std::span<const Path> paths,
                      std::span<char> paths_taken, InsertionScratch& scratch);

}  // namespace acus
