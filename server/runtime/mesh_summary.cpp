// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/runtime/mesh_summary.h"

#include <algorithm>
#include <set>
#include <vector>

#include "server/engine/scene/text/text_table.h"

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

// Of arrays that a region names a group of, or of all where none does: groups without a region of their name. What
// named groups hold already is left out, and all but the first of several with the same tetrahedra.
std::vector<const MeshGroup*> unnamed_groups(const Scene& scene, const TetrahedralMesh& mesh) {
  std::vector<bool> held(mesh.tetrahedra.size());
  std::set<std::string> named_arrays;
  for (const MeshGroup& group : mesh.groups) {
    if (regions_of(scene, group).empty()) continue;
    named_arrays.insert(group.array);
    for (const int t : group.members) held[static_cast<std::size_t>(t)] = true;
  }
  std::vector<const MeshGroup*> unnamed;
  for (const MeshGroup& group : mesh.groups) {
    const auto is_held = [&held](int t) { return held[static_cast<std::size_t>(t)]; };
    const auto same = [&group](const MeshGroup* other) { return other->members == group.members; };
    if (!named_arrays.empty() && !named_arrays.contains(group.array)) continue;
    if (std::ranges::all_of(group.members, is_held) || std::ranges::any_of(unnamed, same)) continue;
    unnamed.push_back(&group);
  }
  return unnamed;
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

void warn_of_unnamed_groups(const Simulation& simulation, SceneWarnings& found) {
  const std::vector<const MeshGroup*> unnamed = unnamed_groups(simulation.scene(), simulation.mesh());
  if (unnamed.size() < 2) return;  // one is the background
  std::string labels;
  for (std::size_t i = 0; i < std::min(unnamed.size(), kShown); ++i)
    labels += (labels.empty() ? "" : ", ") + unnamed[i]->label();
  if (unnamed.size() > kShown) labels += ", and " + std::to_string(unnamed.size() - kShown) + " more";
  found.push_back({"tissue", "no region names these groups of the mesh file, so that nothing tells them apart: " +
                                 labels + "; give them regions with physical_group"});
}

}  // namespace acus
