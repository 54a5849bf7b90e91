// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/scene/files/mesh_file.h"

#include <algorithm>
#include <cmath>

#include "server/engine/mesh_files/mesh_answer.h"
#include "server/engine/scene/files/mesh_process.h"

namespace acus {
namespace {

TetrahedralMesh convert(RawMesh raw, double metres_per_unit) {
  TetrahedralMesh mesh;
  const auto nodes = static_cast<Eigen::Index>(raw.coordinates.size() / 3);
  mesh.nodes = metres_per_unit * Eigen::Map<const Matrix3X>(raw.coordinates.data(), 3, nodes);
  mesh.groups = std::move(raw.groups);
  mesh.notes = std::move(raw.notes);
  mesh.notes.insert(mesh.notes.begin(), "read as " + raw.format);
  mesh.tetrahedra.resize(raw.tetrahedra.size() / 4);
  for (int t = 0; t < mesh.tetrahedron_count(); ++t) {
    std::array<int, 4>& corners = mesh.tetrahedra[t];
    std::copy_n(&raw.tetrahedra[4 * static_cast<std::size_t>(t)], 4, corners.begin());
    if (rest_volume(mesh, t) < 0) std::swap(corners[2], corners[3]);
  }
  return mesh;
}

}  // namespace

TetrahedralMesh read_mesh_file(const std::string& path, double metres_per_unit, const SceneFolders* allowed) {
  try {
    if (!(metres_per_unit > 0) || !std::isfinite(metres_per_unit)) throw MeshError("expected metres_per_unit > 0");
    const std::vector<char> answer = run_mesh_program(mesh_program_path(), path, MeshReadingLimits(), allowed);
    TetrahedralMesh mesh = convert(decode_mesh_answer(answer), metres_per_unit);
    build_topology(mesh);
    return mesh;
  } catch (const MeshError& error) {
    throw MeshError(path + ": " + error.what());
  }
}

}  // namespace acus
