// SPDX-License-Identifier: GPL-3.0-or-later
// Mesh files, read as a server reads them: Gmsh in a process of its own may do what it likes. The first line is the
// ending of the file's name, the rest the file.
#include <unistd.h>

#include <cctype>
#include <fstream>
#include <functional>

#include "server/engine/scene/gmsh_mesh.h"
#include "tests/fuzz/fuzz.h"

namespace {

// libFuzzer sees nothing of the other process: what comes of a file counts as what it reached.
__attribute__((section("__libfuzzer_extra_counters"))) std::uint8_t outcomes[4096];

void tell_outcome(std::string what) {
  std::erase_if(what, [](unsigned char c) { return !std::isalpha(c); });
  outcomes[std::hash<std::string>()(what) % std::size(outcomes)] = 1;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::string stem = "/tmp/acus-fuzz-" + std::to_string(getpid());
  const std::string_view input = acus::fuzz::text_of(data, size);
  const std::size_t line = std::min(input.find('\n'), input.size());
  constexpr std::size_t kLongest = 8;
  const std::string ending(input.substr(0, line));
  if (line > kLongest || ending.find_first_of(std::string("/\0", 2)) != std::string::npos) return 0;
  const std::string path = stem + ending;
  std::ofstream(path, std::ios::binary) << input.substr(std::min(line + 1, input.size()));
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
