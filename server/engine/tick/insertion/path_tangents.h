// SPDX-License-Identifier: GPL-3.0-or-later
// Directions of a path at its vertices and its end.
#pragma once

#include "server/engine/state/path.h"
#include "server/engine/tick/views.h"

namespace acus {

// Vertices that are far enough from the path's end to tell whether the tip is behind or before them.
int holding_vertices(const Path& path);

// Unit, towards the end, by central differences. A path much shorter than its spacing has no direction of its own: what the
// tip slid sideways in a tick would turn it. Up to half a spacing the direction goes over from the needle's to the path's.
Vector3 path_tangent(const TissueView& tissue, const Path& path, int vertex, const Vector3& needle_tangent);
Vector3 end_tangent(const TissueView& tissue, const Path& path, const Vector3& needle_tangent);

// The direction of a path, but no further than sixty degrees from the needle's: rows across a path that runs across the
// needle would pull along the shaft, on which the vertex then runs away.
Vector3 along_needle(const Vector3& path, const Vector3& needle);

}  // namespace acus
