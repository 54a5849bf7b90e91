// SPDX-License-Identifier: GPL-3.0-or-later
// The hub of a needle: a round flat face across the needle at its base, which the surface around the mouth of the
// needle's path stops.
//
// It touches with the lowest point of its rim: at the angle theta to the surface's normal that is R sin theta below the
// middle of the face, R the hub's radius. The surface bears it over a patch, with a dimple in series, as it does a
// blunt tip of that width (obstacle.h), without a limit, and holds it with interaction.friction_contact. Where an
// element is pressed flat the force rises no more. The force acts at the middle of the face, without a moment.
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
