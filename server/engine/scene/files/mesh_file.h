// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "server/engine/models/geometry/tetrahedral_mesh.h"

namespace acus {

class SceneFolders;

// The tetrahedra of a mesh file in any of the formats of mesh_files/formats/readers.h, told by what it holds, and the
// nodes these use in the order of the file's node numbers; coordinates are multiplied by `metres_per_unit`. Other
// volume elements are split (mesh_files/tetrahedra.h), which the mesh's notes tell. A program of its own reads the
// file, acus-mesh, which stands beside this one (mesh_process.h). Tetrahedra written with the other handedness are
// turned. Topology included. With `allowed`, the file must lie in these folders. Throws MeshError that names the file,
// or SceneError for a file outside.
TetrahedralMesh read_mesh_file(const std::string& path, double metres_per_unit, const SceneFolders* allowed = nullptr);

}  // namespace acus
