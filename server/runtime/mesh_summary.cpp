// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/runtime/mesh_summary.h"

#include <algorithm>

#include "server/engine/scene/text_table.h"

namespace acus {
namespace {

constexpr std::size_t kShown = 40;  // groups

std::string regions_of(const Scene& scene, const MeshGroup& group) {
  std::string names;
  for (const Region& region : scene.tissue.regions)
    if (region.physical_group && group.answers_to(*region.physical_group))
      names += (names.empty() ? "" : ", ") + region.name;
  return names;
}

void add_groups(TextTable& table, const Scene& scene, const TetrahedralMesh& mesh) {
  table.add({"  groups", "tetrahedra", "regions"});
  for (std::size_t i = 0; i < std::min(mesh.groups.size(), kShown); ++i) {
    const std::string regions = regions_of(scene, mesh.groups[i]);
    table.add({"    " + mesh.groups[i].label(), std::to_string(mesh.groups[i].members.size()),
               regions.empty() ? "none" : regions});
  }
  if (mesh.groups.size() > kShown) table.add({"    and " + std::to_string(mesh.groups.size() - kShown) + " more"});
}

}  // namespace

std::string summarise_mesh_file(const Simulation& simulation) {
  const TetrahedralMesh& mesh = simulation.mesh();
  if (mesh.notes.empty()) return "";
  TextTable notes, groups;
  notes.add({"mesh file"});
  for (const std::string& note : mesh.notes) notes.add({"  " + note});
  if (!mesh.groups.empty()) add_groups(groups, simulation.scene(), mesh);
  return notes.text() + groups.text();
}

void warn_of_unnamed_groups(const Simulation& simulation, std::vector<SceneWarning>& found) {
  const Scene& scene = simulation.scene();
  const TetrahedralMesh& mesh = simulation.mesh();
  if (mesh.groups.size() < 2) return;
  std::string unnamed;
  std::size_t count = 0;
  for (const MeshGroup& group : mesh.groups) {
    if (!regions_of(scene, group).empty() || ++count > kShown) continue;
    unnamed += (unnamed.empty() ? "" : ", ") + group.label();
  }
  if (count == 0) return;
  if (count > kShown) unnamed += ", and " + std::to_string(count - kShown) + " more";
  found.push_back({"tissue", "no region names these groups of the mesh file: " + unnamed +
                                 "; give each a region with physical_group, or leave them to the regions that take "
                                 "their place"});
}

}  // namespace acus
