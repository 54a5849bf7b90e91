// SPDX-License-Identifier: GPL-3.0-or-later
// The wall of a path beside the needle in it: the tissue that the mesh has at the path's vertices, displaced by what
// the mesh does not resolve (models/unresolved/local_compliance.h). Across the needle the wall touches it. Along the
// needle the friction of the shaft and the cut carry it towards the path's end, by
//
//   a = u(-t_n, X - b) + b     at the distance X from a tip that the part of the path ends at,
//   a = u(-t_n, L)             in a part that the needle leaves by an exit, L its length,
//
// u mouth_displacement() or surface_displacement(), t_n the traction on the needle (state/needle/insertion_state.h). b
// is what the cut carries along, min(e f, g) s(rho): e f is what the mesh lacks ahead of a tip that bears the force f
// of a cut or on a border, g the tip's distance ahead of the path's end at the start of the tick (they differ near a
// border), s that of a dent (models/unresolved/dent.h) at the distance rho = X - e f from the path's end.
//
// So the place where a needle goes into the tissue does not depend on the mesh: a fine mesh has its mouth where a
// coarse one with its wall has it. Depth and lengths of friction count from there (path_transitions.h,
// owned_lengths.h).
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
