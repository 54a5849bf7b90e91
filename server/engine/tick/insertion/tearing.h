// SPDX-License-Identifier: GPL-3.0-or-later
// A path that its needle tears sideways. Tissue beside a shaft bears t per length (Interaction::tear_strength), like
// the wire that cuts it: toughness plus yield stress times diameter [Kamyab, Chakrabarti, Williams 1998]. A vertex
// bears
//
//   T = t l,                      l the length that it supports,
//   T = t K/k at the tip,         k the stiffness per length beside the shaft and K that of the tip
//                                 (models/unresolved/local_compliance.h): the length that it supports and 1.5
//                                 diameters.
//
// From half of that on, what holds the needle sideways in the direction in which it is off its path is a row of
// friction with the threshold T in place of a bilateral one (held_place.h), in series with the same
// springs: it holds as that does up to T, and no more, in the same tick. The direction is that before the laws, in
// which the needle has moved on: that of the last tick's force would turn to and fro where a needle goes further in a
// tick than its springs. What the needle is then off its path beyond its springs is torn: the path goes there through
// the tissue at the tick's end,
//
//   by -F/|F| (d + c F) . F/|F|      d the needle from the path, F the force on the needle, c the springs' compliance.
//
// A force that was above T before, as of a tip that leaves a border that held it, falls to T within some 5 ms.
//
// A tip back inside its path that tears away from it, until the path ahead is 30 degrees off the needle, leaves the old
// cut: its path ends at the tip. Mouths and exits move along the surface; the end of a path that has left the tissue
// goes with its last vertex. Vertices that are torn out of the tissue are forgotten, and a path whose tip is. Borders
// tear with the tissue, but not bone, whose f_p is infinite: the shaft bears on it, by a force that counts for no tear.
// What was torn is no slit: on the way back the tissue holds the needle again.
#pragma once

#include "server/engine/tick/insertion/transition.h"

namespace acus {

// Moves the path of the needle, which it is in, at the end of a tick. Reports a tear as it begins: as a place of the
// path moves at more than 0.1 mm/s, after all have stood still. False if the tip was torn out of the tissue.
bool tear_path(const Transition& now);

}  // namespace acus
