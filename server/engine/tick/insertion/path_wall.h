// SPDX-License-Identifier: GPL-3.0-or-later
// The wall of a path beside the needle in it: the tissue at the path's vertices, displaced by what the mesh does not
// resolve (models/unresolved/local_compliance.h). Across the needle the wall touches it. Along the needle, friction and
// cut carry it towards the path's end by
//
//   a = u(-t_n, X - b) + b     X: distance from a tip at which the part of the path ends,
//   a = u(-t_n, L)             in a part that the needle leaves by an exit, L its length.
//
//   u     mouth_displacement(), surface_displacement()
//   t_n   traction on the needle (state/needle/insertion_state.h)
//   b     advance by the cut: min(e f, g) s(rho), s that of a dent (models/unresolved/dent.h), rho = X - e f
//   e f   compliance ahead of the tip times the force of the cut, or on a border
//   g     distance of the tip ahead of the path's end at the start of the tick; differs from e f near a border
//
// The place where a needle enters the tissue then does not depend on the mesh. Depth and lengths of friction count from
// there (path_transitions.h, owned_lengths.h).
#pragma once

#include "server/engine/models/unresolved/dent.h"
#include "server/engine/tick/insertion/insertion.h"

namespace acus {

// a (m) of a vertex; 0 if that is not alongside.
double wall_advance(const InsertionView& at, const Path& path, const Insertion& state, int vertex);
// a (m) of the path's end where that left the tissue.
double exit_advance(const InsertionView& at, const Path& path, const Insertion& state);
// Whether the needle has come out at the path's end: the tip is past that, or past its wall, which a needle that is
// drawn back carries into the mesh.
bool is_out(const InsertionView& at, const Path& path, const Insertion& state);

// Displacement (m, world) of the wall from the mesh's place: at a vertex alongside, and at the end of a path where
// the needle has come out.
Vector3 wall_move(const InsertionView& at, const Path& path, const Insertion& state, int vertex);
Vector3 exit_move(const InsertionView& at, const Path& path, const Insertion& state);

// What the mesh lacks around the tip in its path.
struct TipWall {
  Vector3 place;  // m, world, on the mesh: what supports the tip
  Vector3 move;   // m, world, from there to the tip; at most 3 R, beyond which the path has lost its tip
  LoadRadii radii;
};

// Of a needle in its path, not through.
TipWall tip_wall(const InsertionView& at, const Path& path, const Insertion& state);

}  // namespace acus
