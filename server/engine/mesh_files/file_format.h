// SPDX-License-Identifier: GPL-3.0-or-later
// Which format a mesh file has, by what it holds. Its name counts only for TetGen's files, which are numbers alone.
#pragma once

#include <string>
#include <string_view>

#include "server/engine/mesh_files/mesh_answer.h"

namespace acus {

// The file's volume elements as tetrahedra. `companion` is the other one of TetGen's two files, empty if there is none.
// Throws MeshError; of a file that is no volume mesh it tells what it is and what to do instead.
RawMesh read_mesh_bytes(std::string_view bytes, const std::string& name, std::string_view companion);

}  // namespace acus
