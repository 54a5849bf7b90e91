// SPDX-License-Identifier: GPL-3.0-or-later
// The hub of a needle: a round flat face across the needle at its base, which the surface around the mouth of the
// needle's path stops.
//
// The surface bears it over a patch, with a dimple in series, as it does a blunt tip of that width (obstacle.h),
// without a limit, and holds it with interaction.friction_contact. Where an element is pressed flat the force rises no
// more.
//
// At the angle theta to the surface's normal n the hub touches with the lowest point of its rim, s = R sin theta below
// the middle of the face, R the hub's radius. It lies on all of its face from where the middle is 2 s deep: the
// pressure of an upright and of a turned punch together, E/(1 - nu²)/pi (D + 2 theta x)/sqrt(R² - r²), is nowhere
// negative there [Johnson, Contact Mechanics, 1985, for both]. From there on the force is that of its middle's depth,
// as without the angle. Until then a spring is in series, with which the force, that of an upright punch at the depth
// D, is smooth in the depth of the middle,
//
//   3 s (D/2s)^(2/3) - s   for D < 2 s,       D   beyond.
//
// The force acts at the middle of the face: a tilted hub has no moment of its own.
//
// A needle outside has no mouth, and its hub meets nothing: what it lies on bears its shaft (shaft_contact.h).
#pragma once

#include "server/engine/tick/contact/contact.h"
#include "server/engine/tick/insertion/insertion.h"

namespace acus {

// The surface around the mouth of the path, under the hub with that state, at the start of the tick.
Obstacle surface_under_hub(const InsertionView& at, const Path& path, const ContactState& state);

// Stage 4, once a tick: sets scratch.located.hub where the hub is near its mouth, and lets its springs creep. `path`:
// the needle's, or null.
void find_hub(const InsertionView& at, const Path* path, InsertionScratch& scratch);
// Stage 5.
void find_hub_contact(const InsertionView& at, InsertionScratch& scratch, Contacts& contacts);

}  // namespace acus
