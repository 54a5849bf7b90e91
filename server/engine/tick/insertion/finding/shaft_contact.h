// SPDX-License-Identifier: GPL-3.0-or-later
// The shaft against surfaces beside its path: a needle that lies on the skin, is bent onto it, or reaches over an edge.
//
// The shaft has cells (state/capacities.h) with one contact each at most, which slides along needle and surface.
// Samples of the cell nearer to the surface than r, 1 mm and twice what the cell moves in the tick, weigh (r - d)², d
// their distance, negative inside. The contact is at their mean, for the length of shaft that is so near. Length within
// 1.5 mm of what path or tip hold (held_stretch.h) counts nothing, from 3 mm on all, and less where the needle stands
// upright on the surface. Place and length of a contact change smoothly.
//
// Rows: a unilateral one along the normal n, in series with the groove (models/unresolved/groove.h), and two of
// friction in the cone of interaction.friction_contact. The surface bears them at three points along the length. n is
// the mean normal at the samples, across the needle; it turns by 1 rad/s and 1 rad per mm of the cell's way at most. A
// contact whose length changes keeps its force per length.
//
// A distance that changes by more than the cell can have moved, as on another face of a fold, leaves an offset that is
// closed at 5 mm/s. So does one that begins deep, as where tissue has sprung over the needle: it bears nothing yet, and
// only what leads deeper; what comes out takes the offset along. Over 10 mm deep none begins (shaft_monitor.h). Where
// an element is pressed flat the force rises no more.
//
// A cell is looked at where its last distance, less its own way and that of the fastest surface node, may be over.
#pragma once

#include "server/engine/tick/contact/contact.h"
#include "server/engine/tick/insertion/insertion.h"

namespace acus {

// Along the needle (m): where one of the kContactPoints points of a contact is, at s and a third of its length to
// either side.
double contact_place(double s, double length, int point, double needle_length);
// The surface under a point p of a needle, against the unit vector n, up to `reach` (m) below it, at the start of the
// tick; looked for from outside. The closest point of the surface, wherever it is, if there is none there.
SurfacePoint surface_under(const TissueView& tissue, const Vector3& p, const Vector3& n, double reach);

// Part of stage 4, once a tick: sets scratch.located.contacts.
void find_shaft_contacts(const InsertionView& at, InsertionScratch& scratch);

Contact make_contact(const InsertionView& at, InsertionScratch& scratch, const ShaftContact& found);

}  // namespace acus
