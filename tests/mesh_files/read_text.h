// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <string>

#include "server/engine/mesh_files/file_format.h"
#include "server/engine/models/geometry/tetrahedral_mesh.h"

namespace acus::test {

inline RawMesh read_text(const std::string& text, const std::string& name = "mesh") {
  return read_mesh_bytes(text, name, "");
}

// What the reader says of a file, "no error" if it is read.
inline std::string error_of(const std::string& text, const std::string& name = "mesh") {
  try {
    read_text(text, name);
  } catch (const MeshError& error) {
    return error.what();
  }
  return "no error";
}

// Tetrahedra with positive volume, and their topology, which needs a mesh without overlaps.
inline TetrahedralMesh with_topology(const RawMesh& raw) {
  TetrahedralMesh mesh;
  mesh.nodes =
      Eigen::Map<const Matrix3X>(raw.coordinates.data(), 3, static_cast<Eigen::Index>(raw.coordinates.size() / 3));
  for (std::size_t t = 0; t < raw.tetrahedra.size(); t += 4)
    mesh.tetrahedra.push_back({raw.tetrahedra[t], raw.tetrahedra[t + 1], raw.tetrahedra[t + 2], raw.tetrahedra[t + 3]});
  for (int t = 0; t < mesh.tetrahedron_count(); ++t)
    if (rest_volume(mesh, t) < 0)
      std::swap(mesh.tetrahedra[static_cast<std::size_t>(t)][2], mesh.tetrahedra[static_cast<std::size_t>(t)][3]);
  build_topology(mesh);
  return mesh;
}

inline double volume(const TetrahedralMesh& mesh) {
  double sum = 0;
  for (int t = 0; t < mesh.tetrahedron_count(); ++t) sum += rest_volume(mesh, t);
  return sum;
}

inline double surface_area(const TetrahedralMesh& mesh) {
  double sum = 0;
  for (const auto& [a, b, c] : mesh.surface) {
    const Vector3 ab = mesh.nodes.col(b) - mesh.nodes.col(a), ac = mesh.nodes.col(c) - mesh.nodes.col(a);
    sum += ab.cross(ac).norm() / 2;
  }
  return sum;
}

inline const MeshGroup* find_group(const RawMesh& mesh, const std::string& text) {
  for (const MeshGroup& group : mesh.groups)
    if (group.answers_to(text)) return &group;
  return nullptr;
}

}  // namespace acus::test
