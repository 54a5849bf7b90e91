// SPDX-License-Identifier: GPL-3.0-or-later
// Gmsh itself runs in acus-mesh (mesh_program.cpp).
#include "server/engine/scene/gmsh_mesh.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string_view>

#include "server/engine/scene/mesh_answer.h"
#include "server/engine/scene/mesh_process.h"

namespace acus {
namespace {

std::string check_ending(const std::string& path) {
  const std::string ending = std::filesystem::path(path).extension().string();
  if (std::find(kMeshEndings.begin(), kMeshEndings.end(), ending) != kMeshEndings.end()) return ending;
  std::string known;
  for (const std::string_view word : kMeshEndings) known.append(known.empty() ? "" : ", ").append(word);
  throw MeshError("expected a mesh file (" + known + "), found the ending \"" + ending + "\"");
}

TetrahedralMesh convert(RawMesh raw, double metres_per_unit) {
  TetrahedralMesh mesh;
  const auto nodes = static_cast<Eigen::Index>(raw.coordinates.size() / 3);
  mesh.nodes = metres_per_unit * Eigen::Map<const Matrix3X>(raw.coordinates.data(), 3, nodes);
  mesh.tag = std::move(raw.groups);
  mesh.tag_names = std::move(raw.group_names);
  mesh.tetrahedra.resize(mesh.tag.size());
  for (int t = 0; t < mesh.tetrahedron_count(); ++t) {
    std::array<int, 4>& corners = mesh.tetrahedra[t];
    std::copy_n(&raw.tetrahedra[4 * static_cast<std::size_t>(t)], 4, corners.begin());
    if (rest_volume(mesh, t) < 0) std::swap(corners[2], corners[3]);
  }
  return mesh;
}

TetrahedralMesh read_file(const std::string& path, double metres_per_unit, const SceneFolders* allowed) {
  if (!(metres_per_unit > 0) || !std::isfinite(metres_per_unit)) throw MeshError("expected metres_per_unit > 0");
  const std::string ending = check_ending(path);
  const std::vector<char> answer = run_mesh_program(mesh_program_path(), path, ending, MeshReadingLimits(), allowed);
  TetrahedralMesh mesh = convert(decode_mesh_answer(answer), metres_per_unit);
  build_topology(mesh);
  return mesh;
}

}  // namespace

TetrahedralMesh read_gmsh_mesh(const std::string& path, double metres_per_unit, const SceneFolders* allowed) {
  try {
    return read_file(path, metres_per_unit, allowed);
  } catch (const MeshError& error) {
    throw MeshError(path + ": " + error.what());
  }
}

}  // namespace acus
