// SPDX-License-Identifier: GPL-3.0-or-later
// Room that is set aside at load: what needles and guides can need in one tick, at most.
#pragma once

#include <span>

#include "server/engine/scene/scene.h"

namespace acus {

// The smallest distance between the vertices of any path (m): a needle may pick up a path that another one has cut.
double least_spacing(std::span<const Needle> needles);

// Path vertices that the shaft can hold at once: they are `spacing` apart or further at rest, and tissue can be
// squeezed along a needle to half of that.
int max_shaft_points(const Needle& parameters, double spacing);
// Lengths into which a shaft is divided where it touches surfaces beside its path
// (tick/insertion/finding/shaft_contact.h): 8 mm or 1.5 spacings, or longer. There is room for twice the vertices that
// a shaft has, and a cell has no more rows and material points than those on its length: they fit beside the vertices
// of a path.
int shaft_cells(const Needle& parameters);
// Rows of an insertion in one tick, at most; `borders`: between regions, which may hold a tip.
int max_insertion_rows(const Needle& parameters, double spacing, bool borders);
// Of all insertions together: not all of them are in squeezed tissue at once, nor all along one, so there is room for
// half more vertices of the one that needs most than it has at rest. Points beyond have no rows, and a flag says so.
int max_insertion_rows(const Scene& scene);
inline constexpr int kPatchPoints =
    21;  // of a tip's contact (tick/contact/contact_patch.h): one, eight and twelve around it
// Material points in the rows of a needle, at most: the shaft's vertices, the path's end, the two vertices around the
// tip, and those of a contact patch.
int max_material_points(const Needle& parameters, double spacing);
// Nodes of the tissue that the rows of a tick touch, at most; `shortest_edge` (m): of the mesh. A line passes four to
// six nodes on the way of an edge through tetrahedra of fair shape; there is room for four times that, as in tissue
// that is squeezed along a needle. What has no room beyond is left out, and a flag says so.
int max_touched_nodes(const Scene& scene, double shortest_edge = 0);
// Those that a deferred field holds: some are held before rows need them, and for a window after.
int max_held_nodes(const Scene& scene);
// Lengths into which a needle is divided where it may touch another one (models/needle/needle_distance.h).
int needle_cells(const Needle& parameters);
// Contacts between needles in one tick, at most, and rows of each.
int max_needle_contacts(const Scene& scene);
inline constexpr int kRowsOfNeedleContact = 3;
// Rows of a guide.
inline constexpr int kMaxGuideRows = 3;

}  // namespace acus
