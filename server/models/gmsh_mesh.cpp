// SPDX-License-Identifier: GPL-3.0-or-later
// The mesh reader of tetrahedral_mesh.h. Gmsh keeps its model in global variables: read one mesh at a time.
#include <gmsh.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <string_view>

#include "server/models/tetrahedral_mesh.h"

namespace acus {
namespace {

constexpr int kLinearTetrahedron = 4;  // Gmsh's number for the element type

// tag_names has an entry for each number up to the largest.
constexpr int kMaxPhysicalGroup = 100'000;

// Gmsh runs whatever it does not recognise as a script, which may start programs. A file with one of these endings
// always meets a mesh reader, except .msh, where its first line decides. Gmsh compares their case too.
constexpr std::array<std::string_view, 7> kMeshEndings{".msh", ".vtk", ".unv", ".mesh", ".bdf", ".nas", ".med"};
constexpr std::array<std::string_view, 3> kMshOpenings{"$MeshFormat", "$NOD", "$Comments"};

// Gmsh's global state from initialize to finalize, without configuration files and without terminal output.
class GmshSession {
 public:
  GmshSession() {
    gmsh::initialize(0, nullptr, false);
    gmsh::option::setNumber("General.Terminal", 0);
    gmsh::logger::start();
  }
  ~GmshSession() {
    gmsh::logger::stop();
    gmsh::finalize();
  }
  GmshSession(const GmshSession&) = delete;
  GmshSession& operator=(const GmshSession&) = delete;
};

template <std::size_t n>
std::string join(const std::array<std::string_view, n>& words) {
  std::string text;
  for (const std::string_view word : words) text.append(text.empty() ? "" : ", ").append(word);
  return text;
}

void check_ending(const std::string& path) {
  const std::string ending = std::filesystem::path(path).extension().string();
  if (std::find(kMeshEndings.begin(), kMeshEndings.end(), ending) != kMeshEndings.end()) return;
  throw MeshError("expected a mesh file (" + join(kMeshEndings) + "), found the ending \"" + ending + "\"");
}

void check_opening(std::istream& file) {
  std::string start(16, '\0');
  file.read(start.data(), static_cast<std::streamsize>(start.size()));
  const auto opens = [&start](std::string_view opening) { return start.rfind(opening, 0) == 0; };
  if (std::any_of(kMshOpenings.begin(), kMshOpenings.end(), opens)) return;
  throw MeshError("expected a Gmsh file that starts with one of " + join(kMshOpenings));
}

void check_file(const std::string& path) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored)) throw MeshError("there is no such file");
  check_ending(path);
  std::ifstream file(path, std::ios::binary);
  if (!file) throw MeshError("the file cannot be opened for reading");
  if (std::filesystem::path(path).extension() == ".msh") check_opening(file);
}

// Gmsh carries on after some errors and leaves them in its log; here each is the end.
void merge_file(const std::string& path) {
  gmsh::merge(path);
  std::vector<std::string> log;
  gmsh::logger::get(log);
  for (const std::string& line : log) {
    if (line.rfind("Error", 0) == 0) throw MeshError("Gmsh says: " + line);
  }
}

// The one physical group of a volume, 0 if it has none.
int physical_group(int volume) {
  std::vector<int> groups;
  gmsh::model::getPhysicalGroupsForEntity(3, volume, groups);
  if (groups.empty()) return 0;
  if (groups.size() > 1) {
    throw MeshError("volume " + std::to_string(volume) + " lies in physical groups " + std::to_string(groups[0]) +
                    " and " + std::to_string(groups[1]) + "; a tetrahedron may belong to one at most");
  }
  const int group = std::abs(groups[0]);
  if (group > kMaxPhysicalGroup) {
    throw MeshError("physical group " + std::to_string(group) + " is numbered above " +
                    std::to_string(kMaxPhysicalGroup));
  }
  return group;
}

// Gmsh's elements as they stand in the file: four node numbers ("tags") and a physical group each.
struct RawElements {
  std::vector<std::size_t> node_tags;  // 4 per tetrahedron
  std::vector<int> groups;             // one per tetrahedron
};

void append_volume(int volume, RawElements& raw) {
  std::vector<int> types;
  std::vector<std::vector<std::size_t>> elements, nodes;
  gmsh::model::mesh::getElements(types, elements, nodes, 3, volume);
  const int group = physical_group(volume);
  for (std::size_t i = 0; i < types.size(); ++i) {
    if (types[i] != kLinearTetrahedron) {
      throw MeshError("volume " + std::to_string(volume) + " holds elements of Gmsh type " + std::to_string(types[i]) +
                      "; expected linear tetrahedra (type 4) only");
    }
    raw.node_tags.insert(raw.node_tags.end(), nodes[i].begin(), nodes[i].end());
    raw.groups.insert(raw.groups.end(), elements[i].size(), group);
  }
}

RawElements read_elements() {
  RawElements raw;
  gmsh::vectorpair volumes;
  gmsh::model::getEntities(volumes, 3);
  for (const auto& [dimension, volume] : volumes) append_volume(volume, raw);
  if (raw.groups.empty()) throw MeshError("the file holds no tetrahedra");
  return raw;
}

// Ascending numbers of the nodes that tetrahedra use: surface meshes and construction points leave others.
std::vector<std::size_t> used_node_tags(const RawElements& raw) {
  std::vector<std::size_t> used = raw.node_tags;
  std::sort(used.begin(), used.end());
  used.erase(std::unique(used.begin(), used.end()), used.end());
  return used;
}

// Position of a number in the ascending list, or -1.
int index_of(const std::vector<std::size_t>& tags, std::size_t tag) {
  const auto found = std::lower_bound(tags.begin(), tags.end(), tag);
  return found != tags.end() && *found == tag ? static_cast<int>(found - tags.begin()) : -1;
}

Matrix3X read_nodes(const std::vector<std::size_t>& used, double metres_per_unit) {
  std::vector<std::size_t> tags;
  std::vector<double> coordinates, parameters;
  gmsh::model::mesh::getNodes(tags, coordinates, parameters);
  Matrix3X nodes(3, static_cast<Eigen::Index>(used.size()));
  std::vector<bool> found(used.size(), false);
  for (std::size_t i = 0; i < tags.size(); ++i) {
    const int node = index_of(used, tags[i]);
    if (node < 0) continue;
    nodes.col(node) = metres_per_unit * Eigen::Map<const Vector3>(&coordinates[3 * i]);
    found[node] = true;
  }
  const auto missing = std::find(found.begin(), found.end(), false);
  if (missing != found.end()) {
    throw MeshError("node " + std::to_string(used[missing - found.begin()]) + " is used but not listed");
  }
  return nodes;
}

std::vector<std::string> read_group_names(const std::vector<int>& groups) {
  std::vector<std::string> names(*std::max_element(groups.begin(), groups.end()) + 1);
  gmsh::vectorpair known;
  gmsh::model::getPhysicalGroups(known, 3);
  for (const auto& [dimension, group] : known) {
    if (group >= 0 && group < static_cast<int>(names.size())) gmsh::model::getPhysicalName(3, group, names[group]);
  }
  return names;
}

TetrahedralMesh convert(const RawElements& raw, double metres_per_unit) {
  const std::vector<std::size_t> used = used_node_tags(raw);
  TetrahedralMesh mesh;
  mesh.nodes = read_nodes(used, metres_per_unit);
  mesh.tag = raw.groups;
  mesh.tag_names = read_group_names(raw.groups);
  mesh.tetrahedra.resize(raw.groups.size());
  for (int t = 0; t < mesh.tetrahedron_count(); ++t) {
    std::array<int, 4>& corners = mesh.tetrahedra[t];
    for (int k = 0; k < 4; ++k) corners[k] = index_of(used, raw.node_tags[4 * t + k]);
    if (rest_volume(mesh, t) < 0) std::swap(corners[2], corners[3]);
  }
  return mesh;
}

TetrahedralMesh read_file(const std::string& path, double metres_per_unit) {
  if (!(metres_per_unit > 0) || !std::isfinite(metres_per_unit)) throw MeshError("expected metres_per_unit > 0");
  check_file(path);
  TetrahedralMesh mesh;
  {
    const GmshSession session;
    merge_file(path);
    mesh = convert(read_elements(), metres_per_unit);
  }
  build_topology(mesh);
  return mesh;
}

}  // namespace

TetrahedralMesh read_gmsh_mesh(const std::string& path, double metres_per_unit) {
  try {
    return read_file(path, metres_per_unit);
  } catch (const MeshError& error) {
    throw MeshError(path + ": " + error.what());
  } catch (const std::string& error) {  // what Gmsh's API throws
    throw MeshError(path + ": Gmsh says: " + error);
  }
}

}  // namespace acus
