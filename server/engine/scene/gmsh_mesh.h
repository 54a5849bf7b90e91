// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <string>
#include <string_view>

#include "server/engine/models/tetrahedral_mesh.h"

namespace acus {

class SceneFolders;

// Gmsh runs whatever it does not recognise as a script, which may start programs. A file with one of these endings
// always meets a mesh reader, except .msh, where its first line decides. Gmsh compares their case too.
inline constexpr std::array<std::string_view, 7> kMeshEndings{".msh", ".vtk", ".unv", ".mesh", ".bdf", ".nas", ".med"};

// Reads mesh files with one of these endings, .msh of every version, and keeps their linear tetrahedra and the nodes
// these use, in the order of the file's node numbers; coordinates are multiplied by `metres_per_unit`. Gmsh runs in a
// program of its own, acus-mesh, which stands beside this one (mesh_process.h). Tetrahedra written with the other
// handedness are turned. Topology included. With `allowed`, the file must lie in these folders. Throws MeshError that
// names the file, or SceneError for a file outside.
TetrahedralMesh read_gmsh_mesh(const std::string& path, double metres_per_unit, const SceneFolders* allowed = nullptr);

}  // namespace acus
