// SPDX-License-Identifier: GPL-3.0-or-later
// What happens to a tip at the tissue's own surface: contact, puncture, and a path that begins, or goes on behind air.
#pragma once

#include "server/engine/tick/insertion/transition.h"

namespace acus {

// Of a tip that is outside, without a path.
void leave_contact_or_puncture(const Transition& now);

// Of a needle that is through: it may be drawn back into its path, or puncture the next surface of a folded tissue.
// `beyond`: the tip is past the end of its path. Returns flags.
std::uint32_t go_through(const Transition& now, Path& path, bool beyond);

// Where a tip stands that is deep enough in the tissue to be noticed.
std::optional<MaterialPoint> noticed_inside(const TissueView& tissue, const Vector3& tip);

// A tip that lost its contact, as elements turned inside out under it, or was torn or thrown into the tissue stands
// there without a path: one is opened, or goes on, from where the shaft crosses the surface last, along it to the tip.
// Where it does not cross, from the nearest point of the surface straight to the tip. Returns flags.
std::uint32_t open_where_found(const Transition& now);

}  // namespace acus
