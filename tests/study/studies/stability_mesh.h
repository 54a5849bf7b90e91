// SPDX-License-Identifier: GPL-3.0-or-later
// Shapes of tetrahedra, and meshes with slivers. Nodes 3 x n (m).
#pragma once

#include <array>

#include "server/engine/models/geometry/tetrahedral_mesh.h"

namespace acus {

// Of all tetrahedra, the smallest angle between two of their faces (rad).
double smallest_dihedral_angle(const TetrahedralMesh& mesh);

// Moves every other node of the inside until the smallest angle between faces beside it is `angle` (rad, above zero and
// below what the mesh has). No tetrahedron is inverted.
void distort_to_slivers(TetrahedralMesh& mesh, double angle);

}  // namespace acus
