// SPDX-License-Identifier: GPL-3.0-or-later
// Stage 4 of an insertion, once a tick: the surface or the border that the tip meets, which path vertices stand alongside
// the shaft and how much of it each owns, and where the tip stands in its path.
//
// Owned length. From halfway to the neighbour on one side to halfway on the other, the first from the surface, the last
// to the tip. The lengths sum to the inserted length at every moment, so that the friction of the whole shaft depends
// neither on the spacing of vertices nor on the moment when one comes or goes.
//
// A tip that is back inside its path lies between the last vertex alongside the shaft, A, and the next one ahead, B (or
// the path's end). It is held to (1 - u) A + u B, u the fraction of the way, with softness (1 - u)²: at u = 1 these are
// the rows that B will have once it is passed, at u = 0, where they would repeat the rows of A with an ever shorter
// lever, they have faded out. Held to the closest point of the polyline instead, it would bear newtons of spikes, there
// and where it passes B, whose offset would close within a tick. tests/validation/insertion_force.cpp holds that
// friction and lateral force are smooth past vertices, both ways.
//
// A tip that cuts is held to the path's end across its cutting direction, which is fixed in the tip's frame: that is
// what steers a bevel. The vertex behind it fades in with its distance d from the end, in spacings, with softness
// ((1 - d)/d)²: two rigid pairs at nearly one place would pull against each other, with tens of kilonewtons at a hand's
// 70 mm/s, and turn the tip by whatever it slid. The vertex is soft and not the tip: the tip's rows are on
// displacements, so a compliance there would let it slip sideways in every tick and steer a bevel less, the shorter the
// tick.
#pragma once

#include <span>

#include "server/simulation/insertion/insertion.h"

namespace acus {

// Starts a needle's tick from what it remembers. `paths_taken`: per path, whether a needle has picked it up in this tick;
// this one may pick up another.
void locate_insertion(const InsertionView& at, const Insertion& before, std::span<const Path> paths,
                      std::span<char> paths_taken, InsertionWork& work);

// Lets the vertices alongside share the needle up to `end` (m).
void share_length(std::span<ShaftPoint> shaft, double end);

}  // namespace acus
