// SPDX-License-Identifier: GPL-3.0-or-later
// The shaft against surfaces beside its path: a needle that lies on the skin, is bent onto it, or reaches over an edge.
//
// The shaft is divided into cells (state/capacities.h), each with one contact at most, which slides along the needle
// and over the surface. Samples of the cell that are nearer to the surface than r, 1 mm and twice what the cell moves
// in the tick, weigh (r - d)², d their distances, negative inside; the contact is at their weighted mean: in the middle
// of a cell that lies flat, over an edge where one pokes in between. It stands for the length of shaft that is so near;
// what is within 1.5 mm of the stretch that path or tip hold (held_stretch.h) counts nothing, from 3 mm on all, and
// less and less where the needle stands upright on the surface. So place and length of a contact change smoothly, and a
// load passes from one cell to the next.
//
// Rows, as of a tip (tip_rows.h): a unilateral one along the normal n, in series with the spring of the groove
// (models/unresolved/groove.h), and two of friction in the cone of interaction.friction_contact. The surface bears them
// at three points along that length. n is the mean of the surface's normals at the samples, made orthogonal to the
// needle: over an edge it turns from one face to the next, no faster than 1 rad/s and 1 rad per mm of the cell's way.
// The distance is measured along n. A contact whose length changes keeps its force per length, as a path vertex does
// (shaft_rows.h).
//
// Where the distance changes by more than the cell can have moved, as where it comes to another face of a fold, an
// offset takes up the difference, which is closed at 5 mm/s. A cell that begins over 1 mm deep, or 4 mm next to shaft
// that is held and at the tip, has no contact (shaft_monitor.h tells it): the closest surface may be on the other side.
// Where an element is pressed flat the force rises no more.
//
// A cell is looked at only where it may be near. Its middle was `distance` from the surface when it was looked at last,
// and since then no nearer than that, less its own way and the way of the fastest node of the surface in each tick.
#pragma once

#include "server/engine/laws/rows.h"
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

// False if a row did not fit.
bool add_contact_rows(const InsertionView& at, const InsertionScratch& scratch, const ShaftContact& contact,
                      Rows& rows);

}  // namespace acus
