// SPDX-License-Identifier: GPL-3.0-or-later
// From the elements of a file to tetrahedra.
//
// Pyramids, prisms and hexahedra are split from their corner of the smallest number: it is joined to every face that
// it is not on, and a quadrilateral is split from its own corner of the smallest number. Two elements that share a
// face so split it alike (Dompierre et al., "How to subdivide pyramids, prisms and hexahedra into tetrahedra", 1999).
// Where that inverts a tetrahedron, as in a twisted hexahedron, all faces are joined to a new node in the middle
// instead. A quadratic tetrahedron becomes eight, along the middles of its edges; where the file has other elements,
// too, or one of the eight would be inverted, the middles of all are left out, so that neighbours still match.
#pragma once

#include "server/engine/mesh_files/mesh_answer.h"
#include "server/engine/mesh_files/mesh_contents.h"

namespace acus {

// Every element of `contents`, whose places are in `file`, and the nodes they use in the order of their numbers. Throws
// MeshError for a number that stands twice, a node that is not there, and an element that cannot be split.
RawMesh make_tetrahedra(const FileText& file, MeshContents contents);

}  // namespace acus
