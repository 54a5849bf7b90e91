// SPDX-License-Identifier: GPL-3.0-or-later
// Mesh files of every format, as acus-mesh reads them. Of TetGen's two files, whose names tell what they are, the first
// byte is the length of the first, over 16; else it is 255.
#include "server/engine/mesh_files/file_format.h"
#include "server/engine/models/geometry/tetrahedral_mesh.h"
#include "tests/fuzz/fuzz.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::string_view text = acus::fuzz::text_of(data + 1, size - 1);
  const bool pair = data[0] != 255;
  const std::size_t first = pair ? std::min<std::size_t>(text.size(), 16 * std::size_t{data[0]}) : text.size();
  try {
    const acus::RawMesh mesh = acus::read_mesh_bytes(text.substr(0, first), pair ? "a.ele" : "a", text.substr(first));
    // What was read is what an answer may hold.
    const acus::RawMesh answer = acus::decode_mesh_answer(acus::encode_mesh(mesh));
    acus::fuzz::require(answer.tetrahedra == mesh.tetrahedra && answer.groups.size() == mesh.groups.size(),
                        "an answer holds the mesh");
  } catch (const acus::MeshError&) {
  }
  return 0;
}
