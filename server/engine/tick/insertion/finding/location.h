// SPDX-License-Identifier: GPL-3.0-or-later
// Stage 4 of an insertion, once a tick: the surface or border ahead of the tip, the path vertices alongside the shaft
// with their lengths (owned_lengths.h), and the place of the tip in its path.
//
// A tip inside its path is between the last vertex alongside, A, and the next one ahead, B (or the path's end). Its
// rows act against (1 - u) A + u B, u the fraction of the distance. A tip that cuts has them against the path's end,
// across its cutting direction: it is off the end by the lateral compliance, and so a bevel steers (path_growth.h).
#pragma once

#include <span>

#include "server/engine/tick/insertion/insertion.h"

namespace acus {

// Starts a needle's tick from its state `before`. `paths_taken`: per path, whether a needle has entered it in this
// tick; this one may enter another.
void locate_insertion(const InsertionView& at, const Insertion& before, std::span<const Path> paths,
                      std::span<char> paths_taken, InsertionScratch& scratch);

}  // namespace acus
