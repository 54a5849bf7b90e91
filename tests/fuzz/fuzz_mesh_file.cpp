// SPDX-License-Identifier: GPL-3.0-or-later
// Mesh files, read as a server reads them: Gmsh in a process of its own may do what it likes. The first byte numbers
// the ending of the file's name, the rest is the file.
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <fstream>
#include <functional>

#include "server/engine/scene/gmsh_mesh.h"
#include "tests/fuzz/fuzz.h"

namespace {

// libFuzzer sees nothing of the other process: what comes of a file counts as what it reached. A message counts up to
// what it repeats of the file.
__attribute__((section("__libfuzzer_extra_counters"))) std::uint8_t outcomes[4096];

void tell_outcome(std::string what) {
  what.resize(std::min(what.find_first_of("\"'"), what.size()));
  std::erase_if(what, [](unsigned char c) { return !std::isalpha(c); });
  outcomes[std::hash<std::string>()(what) % std::size(outcomes)] = 1;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::string stem = "/tmp/acus-fuzz-" + std::to_string(getpid());
  if (size == 0) return 0;
  const std::string path = stem + std::string(acus::kMeshEndings[data[0] % acus::kMeshEndings.size()]);
  std::ofstream(path, std::ios::binary) << acus::fuzz::text_of(data + 1, size - 1);
  try {
    const acus::TetrahedralMesh mesh = acus::read_gmsh_mesh(path, 1);
    acus::fuzz::require(mesh.nodes.allFinite() && mesh.tetrahedron_count() > 0, "a mesh is one");
    tell_outcome("a mesh" + std::string(static_cast<std::size_t>(mesh.node_count()), 'n'));
  } catch (const acus::MeshError& error) {
    tell_outcome(error.what());
  }
  unlink(path.c_str());
  return 0;
}
