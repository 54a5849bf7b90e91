// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/models/tissue/rest_stiffness.h"

#include <map>

#include "server/engine/models/element/corotational_energy.h"

namespace acus {

RestStiffness::RestStiffness(const TissueModel& model) : mesh_(*model.mesh) {
  std::vector<std::map<int, Matrix3>> rows(static_cast<std::size_t>(model.nodes()));
  const auto add = [&](int i, int j, const Matrix3& k) {  // i <= j
    rows[i].try_emplace(j, Matrix3::Zero()).first->second += k;
  };
  PatchGradients patches(model.pressure);
  const double unturned[4] = {1, 0, 0, 0};
  for (int t = 0; t < mesh_.tetrahedron_count(); ++t) {
    const auto& nodes = mesh_.tetrahedra[t];
    double x[4][3];
    gather_nodes(mesh_.nodes, nodes, x);
    const Eigen::Matrix<double, 12, 12> k = corotational_tangent(model.elements[t], x, unturned, false);
    for (int a = 0; a < 4; ++a)
      for (int b = 0; b < 4; ++b) {
        if (nodes[a] > nodes[b]) continue;
        add(nodes[a], nodes[b], k.block<3, 3>(3 * a, 3 * b));
      }
    if (model.pressure.patches() > 0)
      patches.add(t, nodes, volume_strain(model.elements[t], x, unturned).gradient);
  }
  patches.for_each_block([&](int i, int j, const Matrix3& k, double) { add(j, i, k.transpose()); });
  for (const auto& row : rows) {
    start_.push_back(static_cast<int>(blocks_.size()));
    for (const auto& [column, k] : row) {
      blocks_.push_back({column, {}});
      Eigen::Map<Matrix3>(blocks_.back().k) = k;
    }
  }
  start_.push_back(static_cast<int>(blocks_.size()));
}

void RestStiffness::forces(const Matrix3X& x, Matrix3X& displacement, Matrix3X& forces) const {
  displacement = x - mesh_.nodes;
  forces.setZero(3, mesh_.node_count());
  const double* all = displacement.data();
  double* result = forces.data();
  for (int row = 0; row < mesh_.node_count(); ++row) {
    const double* u = all + 3 * row;
    double f[3] = {0, 0, 0};
    for (int b = start_[row]; b < start_[row + 1]; ++b) {
      const Block& block = blocks_[b];
      const double* v = all + 3 * block.column;
      double* g = result + 3 * block.column;
      for (int i = 0; i < 3; ++i) f[i] += block.k[i] * v[0] + block.k[i + 3] * v[1] + block.k[i + 6] * v[2];
      if (block.column == row) continue;
      for (int i = 0; i < 3; ++i) g[i] += block.k[3 * i] * u[0] + block.k[3 * i + 1] * u[1] + block.k[3 * i + 2] * u[2];
    }
    for (int i = 0; i < 3; ++i) result[3 * row + i] += f[i];
  }
}

}  // namespace acus
