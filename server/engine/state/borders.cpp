// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/state/borders.h"

#include <algorithm>

namespace acus {

namespace {

// The interface that a scene lists between two regions, or nullptr.
const Interface* find_interface(const Tissue& tissue, const std::string& a, const std::string& b) {
  const auto joins = [&](const Interface& i) {
    return (i.between == a && i.and_ == b) || (i.between == b && i.and_ == a);
  };
  const auto found = std::find_if(tissue.interfaces.begin(), tissue.interfaces.end(), joins);
  return found == tissue.interfaces.end() ? nullptr : &*found;
}

Border make_border(const Tissue& tissue, const Region& from, const Region& into) {
  const Interface* listed = find_interface(tissue, from.name, into.name);
  Border border{listed ? listed->puncture_force : into.interaction.puncture_force,
                listed ? listed->friction_contact : into.interaction.friction_contact};
  border.holds = border.puncture_force > from.interaction.cutting_force;
  return border;
}

}  // namespace

Borders::Borders(const Tissue& tissue, const TetrahedralMesh& mesh, std::span<const int> regions)
    : regions_(static_cast<int>(tissue.regions.size())) {
  for (const Region& from : tissue.regions)
    for (const Region& into : tissue.regions) table_.push_back(make_border(tissue, from, into));

  std::vector<bool> holds(tissue.regions.size());
  for (int t = 0; t < mesh.tetrahedron_count(); ++t)
    for (const int neighbour : mesh.neighbours[t])
      if (neighbour >= 0 && regions[neighbour] != regions[t] && at(regions[t], regions[neighbour]).holds)
        holds[regions[neighbour]] = any_ = true;
  const std::span<const int> none;
  for (int region = 0; region < regions_; ++region)
    surfaces_.emplace_back(mesh, holds[region] ? regions : none, region);
}

}  // namespace acus
