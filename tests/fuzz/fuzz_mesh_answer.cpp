// SPDX-License-Identifier: GPL-3.0-or-later
// What acus-mesh answers, whatever a file did to it.
#include "server/engine/mesh_files/mesh_answer.h"
#include "server/engine/models/geometry/tetrahedral_mesh.h"
#include "tests/fuzz/fuzz.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    const acus::RawMesh mesh = acus::decode_mesh_answer({reinterpret_cast<const char*>(data), size});
    const auto nodes = static_cast<std::int32_t>(mesh.coordinates.size() / 3);
    for (const std::int32_t node : mesh.tetrahedra) acus::fuzz::require(node >= 0 && node < nodes, "nodes are there");
  } catch (const acus::MeshError&) {
  }
  return 0;
}
