// SPDX-License-Identifier: GPL-3.0-or-later
// A conforming mesh of linear tetrahedra at rest, with the topology that contact and tracing need. Constant after
// it is built.
#pragma once

#include <array>
#include <stdexcept>
#include <string>
#include <vector>

#include "server/engine/math/types.h"
#include "server/engine/models/geometry/clusters.h"
#include "server/engine/models/geometry/mesh_group.h"

namespace acus {

// A mesh that cannot be simulated. The message names the node or the tetrahedron and what is wrong with it.
struct MeshError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

struct TetrahedralMesh {
  Matrix3X nodes;                              // 3 x n, rest positions (m)
  std::vector<std::array<int, 4>> tetrahedra;  // positive volume: det[x1-x0, x2-x0, x3-x0] > 0
  std::vector<MeshGroup> groups;               // of the file it was read from
  std::vector<std::string> notes;              // what reading it has split or left out

  // Derived by build_topology().
  std::vector<std::array<int, 4>> neighbours;  // tetrahedron across the face opposite to node k, or -1
  std::vector<std::array<int, 3>> surface;     // boundary triangles, seen counter-clockwise from outside
  std::vector<int> surface_tetrahedron;        // the tetrahedron that owns each boundary triangle
  Clusters clusters;                           // of the tetrahedra

  int node_count() const { return static_cast<int>(nodes.cols()); }
  int tetrahedron_count() const { return static_cast<int>(tetrahedra.size()); }
};

// Of a tetrahedron with its nodes at `x` (3 x n, m): m³, negative where it is inside out.
double signed_volume(const Matrix3X& x, const std::array<int, 4>& nodes);
// Volume of tetrahedron t at rest (m^3), signed.
double rest_volume(const TetrahedralMesh& mesh, int t);
// Unit vectors a and b such that (a, b, n) is orthonormal and right-handed, for a unit n: turned with the mesh at rest.
void perpendicular_basis(const TetrahedralMesh& mesh, const Vector3& n, Vector3& a, Vector3& b);
// The edge of a regular tetrahedron as large as tetrahedron t at rest (m).
double element_size(const TetrahedralMesh& mesh, int t);
double mean_element_size(const TetrahedralMesh& mesh);  // 0 without any
double shortest_edge(const TetrahedralMesh& mesh);      // at rest (m); infinite without any

// Fills neighbours, surface, surface_tetrahedron and clusters. Throws MeshError for an empty mesh, an index out of
// range, a non-finite node, an inverted or flat tetrahedron, a face shared by more than two tetrahedra or by two that
// overlap, a node that no tetrahedron uses, or a mesh of several parts that do not touch in a face.
void build_topology(TetrahedralMesh& mesh);

// A box centred on the origin, `cells` along each axis, every cell cut into six tetrahedra around one diagonal (Kuhn)
// and the mirror image of its neighbours, so that their faces match. Symmetric about the middle planes across axes with
// an even number of cells. Topology included.
TetrahedralMesh make_box_mesh(const Vector3& size_m, const std::array<int, 3>& cells);

}  // namespace acus
