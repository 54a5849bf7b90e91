// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/validation/mirrored_mesh.h"

#include <fstream>
#include <vector>

namespace acus::test {

namespace {

using Index3 = std::array<int, 3>;

int node_number(const Index3& at, const Index3& cells) {
  return 1 + at[0] + (cells[0] + 1) * (at[1] + (cells[1] + 1) * at[2]);
}

// Six tetrahedra, one for each order in which three edges lead from one corner of the cell to the opposite one; in
// every second cell along an axis the way starts from the other side.
void append_cell(const Index3& cell, const Index3& cells, std::vector<std::array<int, 4>>& tetrahedra) {
  constexpr int kOrders[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
  for (const auto& order : kOrders) {
    Index3 step{0, 0, 0};
    std::array<int, 4> nodes{};
    for (std::size_t k = 0; k < 4; ++k) {
      if (k > 0) step[static_cast<std::size_t>(order[k - 1])] = 1;
      Index3 corner{};
      for (std::size_t axis = 0; axis < 3; ++axis)
        corner[axis] = cell[axis] + (cell[axis] % 2 == 0 ? step[axis] : 1 - step[axis]);
      nodes[k] = node_number(corner, cells);
    }
    tetrahedra.push_back(nodes);
  }
}

}  // namespace

void write_mirrored_box(const std::string& file, const Vector3& size_m, const Index3& cells) {
  std::vector<std::array<int, 4>> tetrahedra;
  for (int k = 0; k < cells[2]; ++k)
    for (int j = 0; j < cells[1]; ++j)
      for (int i = 0; i < cells[0]; ++i) append_cell({i, j, k}, cells, tetrahedra);

  std::ofstream out(file);
  out.precision(17);
  out << "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n" << (cells[0] + 1) * (cells[1] + 1) * (cells[2] + 1) << '\n';
  for (int k = 0; k <= cells[2]; ++k)
    for (int j = 0; j <= cells[1]; ++j)
      for (int i = 0; i <= cells[0]; ++i)
        out << node_number({i, j, k}, cells) << ' ' << size_m.x() * (1.0 * i / cells[0] - 0.5) << ' '
            << size_m.y() * (1.0 * j / cells[1] - 0.5) << ' ' << size_m.z() * (1.0 * k / cells[2] - 0.5) << '\n';
  out << "$EndNodes\n$Elements\n" << tetrahedra.size() << '\n';
  for (std::size_t t = 0; t < tetrahedra.size(); ++t) {
    out << t + 1 << " 4 2 1 1";
    for (const int node : tetrahedra[t]) out << ' ' << node;
    out << '\n';
  }
  out << "$EndElements\n";
}

}  // namespace acus::test
