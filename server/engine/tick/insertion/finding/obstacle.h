// SPDX-License-Identifier: GPL-3.0-or-later
// What stops a tip: the tissue's own surface, or the border of a region inside that holds tips (state/borders.h). Both
// bear it over a patch (contact_patch.h) with a dimple in series (models/unresolved/dimple.h), however large f_p is.
//
// A tip that cuts comes to a border with the force of the cut. Once the border's dimple bears that force (tip_laws.h),
// the cutting row ends, and contact and friction along the border bear the tip.
//
// The surface stops the needle's hub likewise (hub.h).
#pragma once

#include "server/engine/tick/insertion/insertion.h"

namespace acus {

// At a point of the tissue's surface, of a needle outside or through.
Obstacle surface_ahead(const InsertionView& at, const SurfacePoint& point, const Insertion& state);
// The border of a region at the point that is nearest to p, of a needle inside.
Obstacle border_ahead(const InsertionView& at, int region, const Vector3& p, const Insertion& state);

// Fills in what depends on the place of an obstacle and what it bears, of an end with the diameter d (m) that is held
// up to f_p (N). `behind`: as in TissueView::dimple_spring().
void bear_on_patch(const TissueView& tissue, const Surface& surface, int behind, double d, double f_p,
                   const NeedleEnd& end, const Creep& creep, Obstacle& obstacle);

// The end over what bears it, along the obstacle's normal (m), negative beyond it: at the start of the tick and now.
double height_before(const Obstacle& obstacle, const NeedleEnd& end);
double height(const TissueView& tissue, const Obstacle& obstacle, const NeedleEnd& end);
// How far the end has moved from what bears it since the start of the tick (m), along the normal and across.
Vector3 slip(const TissueView& tissue, const Obstacle& obstacle, const NeedleEnd& end);

// The contact of an end with an obstacle that bears `most` (N), without friction. An end that was behind the obstacle
// at the start of the tick by more than its dimple, torn out of its path or carried over a border, is brought back at
// `recovery` (m/s). The offset of a loaded one whose dimple or patch has changed is closed at kSettlingSpeed.
Contact on_obstacle(const InsertionView& at, const Obstacle& obstacle, ContactKind kind, const NeedleEnd& end,
                    double most, double recovery, ContactState& state);
// None where it can bear nothing.
std::optional<DiskFriction> friction_along(const TissueView& tissue, const Obstacle& obstacle, const NeedleEnd& end,
                                           double friction, double cohesion);

// Speed at which the offset of a loaded contact is closed that a change of compliance from element to element leaves.
// Forces change slowly with it.
inline constexpr double kSettlingSpeed = 5e-3;  // m/s
// An offset (m) made smaller by `step` (m).
double shrunk(double offset, double step);

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
