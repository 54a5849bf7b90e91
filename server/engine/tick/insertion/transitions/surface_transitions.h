// SPDX-License-Identifier: GPL-3.0-or-later
// Transitions of a tip at the tissue's own surface: contact, release, puncture, and a new path or a new part of one.
#pragma once

#include "server/engine/tick/insertion/transitions/transition.h"

namespace acus {

// For a tip outside, without a path.
void leave_contact_or_puncture(const Transition& now);

// For a needle that is through: the tip may be pulled back into its path, or puncture the next surface of a folded
// tissue. `beyond`: the tip is past the end of its path. Returns flags.
std::uint32_t go_through(const Transition& now, Path& path, bool beyond);

// The material point of a tip that is more than kUnnoticedDepth deep in the tissue.
std::optional<MaterialPoint> noticed_inside(const TissueView& tissue, const Vector3& tip);

// Opens a path for a tip that is in the tissue without one: elements under it inverted, or it was torn or thrown in.
// The path, or the new part of one, begins where the shaft crosses the surface last and follows the shaft to the tip.
// Without a crossing it runs straight from the nearest point of the surface. Returns flags.
std::uint32_t open_where_found(const Transition& now);

}  // namespace acus
