// SPDX-License-Identifier: GPL-3.0-or-later
// A path that its needle tears sideways. The tissue beside a shaft bears the force t per length
// (Interaction::tear_strength; toughness plus yield stress times diameter of a wire that cuts [Kamyab, Chakrabarti,
// Williams 1998]). A place bears T = t l, l its tearing length (owned_lengths.h).
//
// From T/2 on, one of the rows across the path is friction with the threshold T in series with the springs
// (held_place.h): the row along the needle's distance from the path before the laws. At the end of the tick the path
// moves through the tissue by
//
//   -F/|F| (d + c F) . F/|F|      d the needle from the path, F the force on the needle, c the springs' compliance.
//
// A force above T, as of a tip that leaves a border, falls to T within 5 ms. A tip inside its path that tears away from
// it by 30 degrees ends the path there. Mouths and exits move along the surface. Vertices that come out of the tissue
// are removed, and so is a path whose tip does. Bone (f_p infinite) is not torn, and what it bears counts for no tear.
#pragma once

#include "server/engine/tick/insertion/transitions/transition.h"

namespace acus {

// Moves the path of the needle, which it is in, at the end of a tick. Reports a tear as it begins: as a place of the
// path moves at more than 0.1 mm/s, after all have stood still. False if the tip was torn out of the tissue.
bool tear_path(const Transition& now);

}  // namespace acus
