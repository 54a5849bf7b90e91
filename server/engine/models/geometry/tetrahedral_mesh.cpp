// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/models/geometry/tetrahedral_mesh.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <sstream>

#include "server/engine/math/rotation.h"

namespace acus {
namespace {

// The face opposite to node k of a positive tetrahedron, counter-clockwise from outside.
constexpr std::array<std::array<int, 3>, 4> kOppositeFace{{{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}};

// A tetrahedron whose volume is below this fraction of its longest edge cubed (a regular one has 0.118) is flat: its
// stiffness would swamp everything around it in rounding errors.
constexpr double kFlatness = 1e-9;

// Tetrahedra in a cluster: larger ones share fewer of their nodes with others, in smaller ones fewer tetrahedra are
// looked at.
constexpr int kClusterTetrahedra = 64;

struct Face {
  std::array<int, 3> key;  // the three nodes, ascending
  bool odd;                // whether `key` is an odd permutation of the outward order
  int tetrahedron;
  int opposite;  // local number of the node that the face does not contain

  bool operator<(const Face& other) const { return key < other.key; }
};

std::array<int, 3> outward_face(const TetrahedralMesh& mesh, int t, int opposite) {
  const std::array<int, 4>& corners = mesh.tetrahedra[t];
  const std::array<int, 3>& face = kOppositeFace[opposite];
  return {corners[face[0]], corners[face[1]], corners[face[2]]};
}

Face make_face(const TetrahedralMesh& mesh, int t, int opposite) {
  Face face{outward_face(mesh, t, opposite), false, t, opposite};
  const auto order = [&face](int a, int b) {
    if (face.key[a] <= face.key[b]) return;
    std::swap(face.key[a], face.key[b]);
    face.odd = !face.odd;
  };
  order(0, 1);
  order(1, 2);
  order(0, 1);
  return face;
}

// "tetrahedron 7 at (0.01, 0.02, 0.03) m": the number is ours, the place is what the author of a mesh can look up.
std::string describe(const TetrahedralMesh& mesh, int t) {
  const std::array<int, 4>& c = mesh.tetrahedra[t];
  const Vector3 centre =
      (mesh.nodes.col(c[0]) + mesh.nodes.col(c[1]) + mesh.nodes.col(c[2]) + mesh.nodes.col(c[3])) / 4;
  std::ostringstream text;
  text << "tetrahedron " << t << " at (" << centre.x() << ", " << centre.y() << ", " << centre.z() << ") m";
  return text.str();
}

void check_nodes(const TetrahedralMesh& mesh) {
  for (int i = 0; i < mesh.node_count(); ++i) {
    if (!mesh.nodes.col(i).allFinite()) {
      throw MeshError("node " + std::to_string(i) + " has a coordinate that is not finite");
    }
  }
}

void check_indices(const TetrahedralMesh& mesh) {
  std::vector<bool> used(static_cast<std::size_t>(mesh.node_count()), false);
  for (int t = 0; t < mesh.tetrahedron_count(); ++t) {
    for (const int node : mesh.tetrahedra[t]) {
      if (node < 0 || node >= mesh.node_count()) {
        throw MeshError("tetrahedron " + std::to_string(t) + " names node " + std::to_string(node) +
                        ", expected 0 to " + std::to_string(mesh.node_count() - 1));
      }
      used[node] = true;
    }
  }
  const auto unused = std::find(used.begin(), used.end(), false);
  if (unused != used.end()) {
    throw MeshError("node " + std::to_string(unused - used.begin()) + " belongs to no tetrahedron");
  }
}

double longest_edge(const TetrahedralMesh& mesh, int t) {
  const std::array<int, 4>& c = mesh.tetrahedra[t];
  double longest = 0;
  for (int i = 0; i < 4; ++i) {
    for (int j = i + 1; j < 4; ++j) {
      longest = std::max(longest, (mesh.nodes.col(c[i]) - mesh.nodes.col(c[j])).norm());
    }
  }
  return longest;
}

void check_volumes(const TetrahedralMesh& mesh) {
  for (int t = 0; t < mesh.tetrahedron_count(); ++t) {
    const double edge = longest_edge(mesh, t);
    const double flat_volume = kFlatness * edge * edge * edge;
    const double volume = rest_volume(mesh, t);
    if (volume < -flat_volume) throw MeshError(describe(mesh, t) + " is inverted: its volume is negative");
    if (!(volume > flat_volume)) throw MeshError(describe(mesh, t) + " is flat: its nodes lie in a plane");
  }
}

std::vector<Face> sorted_faces(const TetrahedralMesh& mesh) {
  std::vector<Face> faces;
  faces.reserve(4 * mesh.tetrahedra.size());
  for (int t = 0; t < mesh.tetrahedron_count(); ++t) {
    for (int k = 0; k < 4; ++k) faces.push_back(make_face(mesh, t, k));
  }
  std::sort(faces.begin(), faces.end());
  return faces;
}

void join(TetrahedralMesh& mesh, const Face& a, const Face& b) {
  // Neighbours see their common face from opposite sides; equal orientations mean that one lies inside the other.
  if (a.odd == b.odd) {
    throw MeshError(describe(mesh, a.tetrahedron) + " and " + describe(mesh, b.tetrahedron) +
                    " overlap: they lie on the same side of their common face");
  }
  mesh.neighbours[a.tetrahedron][a.opposite] = b.tetrahedron;
  mesh.neighbours[b.tetrahedron][b.opposite] = a.tetrahedron;
}

void find_neighbours(TetrahedralMesh& mesh) {
  mesh.neighbours.assign(mesh.tetrahedra.size(), {-1, -1, -1, -1});
  const std::vector<Face> faces = sorted_faces(mesh);
  for (std::size_t i = 0; i + 1 < faces.size(); ++i) {
    if (faces[i].key != faces[i + 1].key) continue;
    if (i + 2 < faces.size() && faces[i].key == faces[i + 2].key) {
      throw MeshError("a face of " + describe(mesh, faces[i].tetrahedron) +
                      " is shared by more than two tetrahedra; remove duplicated or overlapping elements");
    }
    join(mesh, faces[i], faces[i + 1]);
  }
}

void find_surface(TetrahedralMesh& mesh) {
  mesh.surface.clear();
  mesh.surface_tetrahedron.clear();
  for (int t = 0; t < mesh.tetrahedron_count(); ++t) {
    for (int k = 0; k < 4; ++k) {
      if (mesh.neighbours[t][k] >= 0) continue;
      mesh.surface.push_back(outward_face(mesh, t, k));
      mesh.surface_tetrahedron.push_back(t);
    }
  }
}

// Walks from tetrahedron 0 through common faces and must meet every other one.
void check_connected(const TetrahedralMesh& mesh) {
  std::vector<bool> reached(mesh.tetrahedra.size(), false);
  std::vector<int> front{0};
  reached[0] = true;
  std::size_t count = 1;
  while (!front.empty()) {
    const int t = front.back();
    front.pop_back();
    for (const int neighbour : mesh.neighbours[t]) {
      if (neighbour < 0 || reached[neighbour]) continue;
      reached[neighbour] = true;
      ++count;
      front.push_back(neighbour);
    }
  }
  if (count == mesh.tetrahedra.size()) return;
  const auto outside = static_cast<int>(std::find(reached.begin(), reached.end(), false) - reached.begin());
  throw MeshError("the mesh falls apart: " + describe(mesh, outside) + " is not connected to " + describe(mesh, 0) +
                  " through common faces (" + std::to_string(count) + " of " + std::to_string(mesh.tetrahedra.size()) +
                  " tetrahedra are); keep one part, or join them");
}

}  // namespace

double signed_volume(const Matrix3X& x, const std::array<int, 4>& nodes) {
  const Vector3 x0 = x.col(nodes[0]);
  const Vector3 e1 = x.col(nodes[1]) - x0;
  const Vector3 e2 = x.col(nodes[2]) - x0;
  const Vector3 e3 = x.col(nodes[3]) - x0;
  return e1.dot(e2.cross(e3)) / 6;
}

double rest_volume(const TetrahedralMesh& mesh, int t) { return signed_volume(mesh.nodes, mesh.tetrahedra[t]); }

void perpendicular_basis(const TetrahedralMesh& mesh, const Vector3& n, Vector3& a, Vector3& b) {
  const auto& nodes = mesh.tetrahedra[0];
  const Vector3 origin = mesh.nodes.col(nodes[0]);
  const Vector3 x = (mesh.nodes.col(nodes[1]) - origin).normalized();
  const Vector3 z = x.cross(mesh.nodes.col(nodes[2]) - origin).normalized();
  Matrix3 axes;
  axes << x, z.cross(x), z;
  const Quaternion frame(axes);
  perpendicular_basis(frame.conjugate() * n, a, b);
  a = frame * a;
  b = frame * b;
}

double element_size(const TetrahedralMesh& mesh, int t) {
  return std::cbrt(6 * std::numbers::sqrt2 * rest_volume(mesh, t));
}

double mean_element_size(const TetrahedralMesh& mesh) {
  double sum = 0;
  for (int t = 0; t < mesh.tetrahedron_count(); ++t) sum += element_size(mesh, t);
  return sum / std::max(1, mesh.tetrahedron_count());
}

double shortest_edge(const TetrahedralMesh& mesh) {
  double shortest = std::numeric_limits<double>::infinity();
  for (const std::array<int, 4>& nodes : mesh.tetrahedra)
    for (int a = 1; a < 4; ++a)
      for (int b = 0; b < a; ++b)
        shortest = std::min(shortest, (mesh.nodes.col(nodes[a]) - mesh.nodes.col(nodes[b])).norm());
  return shortest;
}

void build_topology(TetrahedralMesh& mesh) {
  if (mesh.tetrahedra.empty()) throw MeshError("the mesh has no tetrahedra");
  check_nodes(mesh);
  check_indices(mesh);
  check_volumes(mesh);
  find_neighbours(mesh);
  find_surface(mesh);
  check_connected(mesh);
  mesh.clusters = Clusters(mesh.nodes, mesh.tetrahedra, kClusterTetrahedra);
}

}  // namespace acus
