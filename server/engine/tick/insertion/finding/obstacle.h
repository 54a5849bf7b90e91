// SPDX-License-Identifier: GPL-3.0-or-later
// What stops a tip: the tissue's own surface, or the border of a region inside that holds tips (state/borders.h). Both
// bear it over a patch (contact_patch.h) with a dimple in series (models/unresolved/dimple.h), however large f_p is.
//
// A tip that cuts comes to a border with the force of the cut. Once the border's dimple bears that force (tip_laws.h),
// the cutting row ends, and contact and friction along the border bear the tip.
#pragma once

#include "server/engine/tick/insertion/insertion.h"

namespace acus {

// At a point of the tissue's surface, of a needle outside or through.
Obstacle surface_ahead(const InsertionView& at, const SurfacePoint& point, const Insertion& state);
// The border of a region at the point that is nearest to p, of a needle inside.
Obstacle border_ahead(const InsertionView& at, int region, const Vector3& p, const Insertion& state);

// The tip over what bears it, along the obstacle's normal (m), negative beyond it: at the start of the tick and now.
double height_before(const InsertionView& at, const Obstacle& obstacle);
double height(const InsertionView& at, const Obstacle& obstacle);
// How far the tip has moved from what bears it since the start of the tick (m), along the normal and across.
Vector3 slip(const InsertionView& at, const Obstacle& obstacle);

// From a tip at the end of a path, `height` (m) over a border; none if the cutting direction leads away from it.
BorderAhead border_on_the_way(const InsertionView& at, const Path& path, const Obstacle& border, double height);

// The border bears all that the tip does.
void press_on_border(const InsertionView& at, const Obstacle& border, TipState& tip);
// What the tip does goes on as a cut, along its cutting direction.
void cut_beside_border(const InsertionView& at, const Path& path, const Obstacle& border, TipState& tip);

// Displacement (m, world) of a path's vertex on the border that a tip presses into, by what the mesh lacks of the
// dimple (models/unresolved/dent.h); 0 of one elsewhere. A tip that slides lays vertices at its path's end: there the
// tissue is where the tip is.
Vector3 beside_dimple(const InsertionView& at, const Path& path, const InsertionScratch& scratch,
                      const MaterialPoint& vertex);

}  // namespace acus
