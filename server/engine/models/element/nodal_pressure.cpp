// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/models/element/nodal_pressure.h"

#include <algorithm>
#include <map>
#include <utility>

namespace acus {

namespace {

void find_nodes(const TetrahedralMesh& mesh, NodalPressure& model) {
  std::vector<std::vector<int>> around(static_cast<std::size_t>(model.patches()));
  for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t)
    for (const int patch : model.of_element[t])
      around[patch].insert(around[patch].end(), mesh.tetrahedra[t].begin(), mesh.tetrahedra[t].end());
  for (std::vector<int>& nodes : around) {
    std::sort(nodes.begin(), nodes.end());
    nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
    model.first_node.push_back(static_cast<int>(model.nodes.size()));
    model.nodes.insert(model.nodes.end(), nodes.begin(), nodes.end());
  }
  model.first_node.push_back(static_cast<int>(model.nodes.size()));
}

// Lanes behind the last element repeat it; they have no volume.
void fill_batches(NodalPressure& model) {
  const int count = static_cast<int>(model.of_element.size());
  model.batches.resize(static_cast<std::size_t>((count + kLanes - 1) / kLanes));
  for (int i = 0; i < static_cast<int>(model.batches.size()) * kLanes; ++i)
    for (int k = 0; k < 4; ++k)
      model.batches[i / kLanes].patches[k][i % kLanes] = model.of_element[std::min(i, count - 1)][k];
}

}  // namespace

NodalPressure make_nodal_pressure(const TetrahedralMesh& mesh, std::span<const int> region_of,
                                  const std::vector<double>& volumes, const std::vector<double>& modulus,
                                  const std::vector<double>& damping) {
  NodalPressure model;
  if (std::all_of(modulus.begin(), modulus.end(), [](double m) { return m == 0; })) return model;
  std::map<std::pair<int, int>, int> patch_of;  // node and region
  std::vector<double> volume;
  std::vector<int> region;
  for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t) {
    auto& patches = model.of_element.emplace_back();
    for (int k = 0; k < 4; ++k) {
      const std::pair key{mesh.tetrahedra[t][k], region_of[t]};
      const auto [place, is_new] = patch_of.try_emplace(key, static_cast<int>(volume.size()));
      if (is_new) {
        volume.push_back(0);
        region.push_back(region_of[t]);
      }
      patches[k] = place->second;
      volume[patches[k]] += volumes[t] / 4;
    }
  }
  model.volume = Eigen::Map<const VectorX>(volume.data(), static_cast<Eigen::Index>(volume.size()));
  model.modulus.resize(model.patches());
  model.damping.resize(model.patches());
  for (int a = 0; a < model.patches(); ++a) {
    model.modulus[a] = modulus[region[a]];
    model.damping[a] = damping[region[a]];
  }
  find_nodes(mesh, model);
  fill_batches(model);
  return model;
}

double mean_pressure(const NodalPressure& model, int tetrahedron, const VectorX& pressures) {
  double sum = 0;
  for (const int patch : model.of_element[tetrahedron]) sum += pressures[patch];
  return sum / 4;
}

PatchGradients::PatchGradients(const NodalPressure& model)
    : model_(model), columns_(Matrix3X::Zero(3, static_cast<Eigen::Index>(model.nodes.size()))) {}

void PatchGradients::add(int tetrahedron, const std::array<int, 4>& nodes,
                         const Eigen::Matrix<double, 3, 4>& gradient) {
  for (const int patch : model_.of_element[tetrahedron]) {
    const auto of_patch = model_.nodes_of(patch);
    for (int k = 0; k < 4; ++k) {
      const auto at = std::lower_bound(of_patch.begin(), of_patch.end(), nodes[k]) - of_patch.begin();
      columns_.col(model_.first_node[patch] + at) += gradient.col(k) / 4;
    }
  }
}

}  // namespace acus
