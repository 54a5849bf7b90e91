// SPDX-License-Identifier: GPL-3.0-or-later
// Mesh files, read as a server reads them: Gmsh in a process of its own may do what it likes.
#include <unistd.h>

#include <fstream>

#include "server/engine/scene/gmsh_mesh.h"
#include "tests/fuzz/fuzz.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::string path = "/tmp/acus-fuzz-" + std::to_string(getpid()) + ".msh";
  std::ofstream(path, std::ios::binary) << acus::fuzz::text_of(data, size);
  try {
    const acus::TetrahedralMesh mesh = acus::read_gmsh_mesh(path, 1);
    acus::fuzz::require(mesh.nodes.allFinite() && mesh.tetrahedron_count() > 0, "a mesh is one");
  } catch (const acus::MeshError&) {
  }
  unlink(path.c_str());
  return 0;
}
