// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/study/studies/stability_mesh.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

namespace acus {

namespace {

// Halves an interval often enough for the angle to come out to its last digits.
constexpr int kBisections = 60;

using Tetrahedron = std::array<int, 4>;

// Between the two faces that meet in the edge of nodes i and j (rad).
double dihedral_angle(const Matrix3X& x, const Tetrahedron& nodes, int i, int j) {
  int others[2], count = 0;
  for (int k = 0; k < 4; ++k)
    if (k != i && k != j) others[count++] = k;
  const Vector3 from = x.col(nodes[i]), edge = (x.col(nodes[j]) - from).normalized();
  const auto across = [&](int k) {
    const Vector3 arm = x.col(nodes[k]) - from;
    return Vector3(arm - arm.dot(edge) * edge);
  };
  const Vector3 a = across(others[0]), b = across(others[1]);
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

// The smallest angle of a tetrahedron, zero where it is flat or inverted.
double smallest_angle(const Matrix3X& x, const Tetrahedron& nodes) {
  if (signed_volume(x, nodes) <= 0) return 0;
  double smallest = std::numbers::pi;
  for (int i = 0; i < 4; ++i)
    for (int j = i + 1; j < 4; ++j) smallest = std::min(smallest, dihedral_angle(x, nodes, i, j));
  return smallest;
}

std::vector<std::vector<int>> tetrahedra_of_nodes(const TetrahedralMesh& mesh) {
  std::vector<std::vector<int>> lists(static_cast<std::size_t>(mesh.node_count()));
  for (int t = 0; t < mesh.tetrahedron_count(); ++t)
    for (const int node : mesh.tetrahedra[t]) lists[node].push_back(t);
  return lists;
}

std::vector<bool> nodes_on_surface(const TetrahedralMesh& mesh) {
  std::vector<bool> on_surface(static_cast<std::size_t>(mesh.node_count()));
  for (const auto& triangle : mesh.surface)
    for (const int node : triangle) on_surface[node] = true;
  return on_surface;
}

double smallest_angle_beside(const TetrahedralMesh& mesh, const std::vector<int>& tetrahedra) {
  double smallest = std::numbers::pi;
  for (const int t : tetrahedra) smallest = std::min(smallest, smallest_angle(mesh.nodes, mesh.tetrahedra[t]));
  return smallest;
}

// Moves a node along a direction until an element beside it has the angle.
void move_node(TetrahedralMesh& mesh, int node, const std::vector<int>& beside, const Vector3& direction,
               double angle) {
  const Vector3 start = mesh.nodes.col(node);
  double near = 0, far = 1;  // of the direction; too far, an element beside the node is inverted
  for (int i = 0; i < kBisections; ++i) {
    const double middle = (near + far) / 2;
    mesh.nodes.col(node) = start + middle * direction;
    (smallest_angle_beside(mesh, beside) >= angle ? near : far) = middle;
  }
  mesh.nodes.col(node) = start + near * direction;
}

// No two nodes in the same direction, none along a face of the box.
Vector3 direction_of(int node) {
  return Vector3(std::sin(1.0 + 2.1 * node), std::sin(2.0 + 3.3 * node), std::sin(3.0 + 4.7 * node)).normalized();
}

}  // namespace

double smallest_dihedral_angle(const TetrahedralMesh& mesh) {
  double smallest = std::numbers::pi;
  for (const Tetrahedron& nodes : mesh.tetrahedra) smallest = std::min(smallest, smallest_angle(mesh.nodes, nodes));
  return smallest;
}

void distort_to_slivers(TetrahedralMesh& mesh, double angle) {
  const auto tetrahedra = tetrahedra_of_nodes(mesh);
  const auto on_surface = nodes_on_surface(mesh);
  const double size = (mesh.nodes.rowwise().maxCoeff() - mesh.nodes.rowwise().minCoeff()).maxCoeff();
  for (int node = 0; node < mesh.node_count(); node += 2)
    if (!on_surface[node]) move_node(mesh, node, tetrahedra[node], size * direction_of(node), angle);
}

}  // namespace acus
