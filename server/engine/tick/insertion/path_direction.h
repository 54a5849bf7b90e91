// SPDX-License-Identifier: GPL-3.0-or-later
// Directions of a path: tangents at its vertices and its end, and the way of a cut through the material.
//
// The way of a cut. A tip's force shears the elements around it, small elements more: a path that followed one element
// would depend on the mesh. The rotation of the tissue is therefore measured on four material lines beside the tip,
// parallel to the cutting direction. D is their sum at rest, d their sum now; the cutting direction is turned back by
// the smallest rotation that takes D to d. What a needle drags along moves opposite lines by opposite amounts.
#pragma once

#include "server/engine/state/needle/path.h"
#include "server/engine/tick/views.h"

namespace acus {

// Number of vertices, without a last one so near the path's end that it is one place with it.
int holding_vertices(const Path& path);

// Unit, towards the end, by central differences. A path much shorter than its spacing has no direction of its own: a
// small sideways slip of the tip would turn it. Up to half a spacing the tangent is a mean of the needle's and the
// path's.
Vector3 path_tangent(const TissueView& tissue, const Path& path, int vertex, const Vector3& needle_tangent);
Vector3 end_tangent(const TissueView& tissue, const Path& path, const Vector3& needle_tangent);

// The direction of a path, limited to sixty degrees from the needle's. Where a path runs across the needle, rows across
// the path would pull along the shaft, and the vertex would run away along it.
Vector3 along_needle(const Vector3& path, const Vector3& needle);

inline constexpr double kBeside = 20e-3;  // m, distance of the material lines at rest; less where the tissue ends
inline constexpr double kAlong = 10e-3;   // m, half of their length, likewise

// `direction` (unit, world) turned back to the tissue at rest by the rotation of the tissue around `place`; unit.
Vector3 direction_at_rest(const TissueView& tissue, const MaterialPoint& place, const Vector3& direction);

// The displacement (m, world) from `place` along the material line in direction_at_rest() whose component along
// `direction` is `way` (m, > 0). Straight where the tissue ends or is crushed.
Vector3 way_through_material(const TissueView& tissue, const MaterialPoint& place, const Vector3& direction,
                             double way);

}  // namespace acus
