// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/tick/notched_block.h"

#include <cmath>
#include <map>
#include <sstream>
#include <vector>

#include "server/engine/models/geometry/tetrahedral_mesh.h"

namespace acus::test {

namespace {

constexpr double kCell = 5e-3, kHalf = 30e-3;  // m, along z

// The height of the slot's walls, or of what lies between a wall and an outer face.
double moved(double z, double slot) {
  if (std::abs(z) < kCell) return z * slot / (2 * kCell);
  return std::copysign(slot / 2 + (std::abs(z) - kCell) * (kHalf - slot / 2) / (kHalf - kCell), z);
}

}  // namespace

std::string notched_block(double slot) {
  const TetrahedralMesh block = make_box_mesh(Vector3::Constant(0.06), {6, 6, 12});
  std::map<int, int> numbers;  // of the nodes in use
  std::vector<std::array<int, 4>> kept;
  for (const auto& tetrahedron : block.tetrahedra) {
    Vector3 middle = Vector3::Zero();
    for (const int node : tetrahedron) middle += block.nodes.col(node) / 4;
    if (std::abs(middle.z()) < kCell && middle.x() < 10e-3) continue;
    for (const int node : tetrahedron) numbers.emplace(node, 0);
    kept.push_back(tetrahedron);
  }
  std::ostringstream text;
  text.precision(12);
  text << "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n" << numbers.size() << '\n';
  int count = 0;
  for (auto& [node, number] : numbers) {
    number = ++count;
    const Vector3 p = block.nodes.col(node);
    text << number << ' ' << p.x() << ' ' << p.y() << ' ' << moved(p.z(), slot) << '\n';
  }
  text << "$EndNodes\n$Elements\n" << kept.size() << '\n';
  for (std::size_t i = 0; i < kept.size(); ++i) {
    text << i + 1 << " 4 2 1 1";
    for (const int node : kept[i]) text << ' ' << numbers[node];
    text << '\n';
  }
  text << "$EndElements\n";
  return text.str();
}

}  // namespace acus::test
