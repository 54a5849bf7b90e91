// SPDX-License-Identifier: GPL-3.0-or-later
// Where a direction of the world points in the tissue at rest. A tip cuts through material, and the force that it bears
// there shears the elements around it, the more the smaller they are: a path that went straight through what an element
// makes of that would turn with the mesh. So the tissue's rotation is taken from a distance, where the needle's own forces
// move it little and evenly: from four material lines beside the place, parallel to the direction. With D their sum at
// rest and d their sum now, the direction is turned back by the smallest rotation that takes D to d. What a needle drags
// along its way moves opposite lines apart or together, and cancels.
#pragma once

#include "server/engine/tick/views.h"

namespace acus {

inline constexpr double kBeside = 20e-3;  // m, of the lines from the place, at rest; nearer where the tissue ends
inline constexpr double kAlong = 10e-3;   // m, half of their length, likewise

// `direction` (unit, world) turned back to the tissue at rest by the rotation of the tissue around `place`; unit.
Vector3 direction_at_rest(const TissueView& tissue, const MaterialPoint& place, const Vector3& direction);

// The way (m, world) from `place` along the material line in direction_at_rest() that comes `way` (m, > 0) along
// `direction`; straight on where the tissue ends, or is crushed.
Vector3 way_through_material(const TissueView& tissue, const MaterialPoint& place, const Vector3& direction, double way);

}  // namespace acus
