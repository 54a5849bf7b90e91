// SPDX-License-Identifier: GPL-3.0-or-later
// The tissue as it is to be drawn: the mesh with dents (models/unresolved/dent.h) around tips and the mouths of paths,
// so that a tip presses on the skin and does not stand in it, and paths where their walls are (insertion/path_wall.h).
// A dent is
//
//   on a surface that a tip presses on       from the contact point on the mesh to the tip; radii of dimple.h
//   at a mouth or exit that a needle is in   from the vertex to the wall; radii of a shaft
//   around a tip inside                      from what supports it to the tip; radii of a tip
//   under a shaft that lies on a surface     from the surface to the needle, at points of contact; radii of groove.h
//
// All together displace each of these places that far, to a hundredth of a millimetre, unless two are at one place.
// Nothing of the tick depends on this, and only those who ask for it pay for it.
#pragma once

#include <vector>

#include "server/engine/models/unresolved/dent.h"
#include "server/engine/state/model.h"
#include "server/engine/state/state.h"

namespace acus {

// With room for all that a model can have; filling it in allocates nothing.
struct DrawnTissue {
  std::vector<Dent> dents;
  Matrix3X path_points;         // 3 x room, m, world: one path after the other, each mouth first
  std::vector<int> path_sizes;  // points of each path that there is
  int points = 0;               // used columns of path_points

  std::vector<NeedleShape> shapes;  // scratch, per needle
  std::vector<Vector3> wanted;      // scratch: the displacements of the dents' centres

  explicit DrawnTissue(const Model& model);
};

void draw_tissue(const Model& model, const State& state, DrawnTissue& drawn);

}  // namespace acus
