// SPDX-License-Identifier: GPL-3.0-or-later
// acus-mesh: reads one mesh file and answers in the layout of mesh_answer.h. Started by mesh_process.cpp with the mesh
// on standard input, its companion on descriptor 4, and a pipe for the answer on descriptor 3.
//
//   acus-mesh NAME MEMORY_BYTES PROCESSOR_SECONDS
//
// NAME is the file's, without folders. What a damaged file might turn this program to is closed before it is read
// (mesh_confinement.h).
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <new>
#include <span>
#include <string>
#include <vector>

#include "server/engine/mesh_files/file_format.h"
#include "server/engine/mesh_files/mesh_confinement.h"
#include "server/engine/models/geometry/tetrahedral_mesh.h"

namespace acus {
namespace {

constexpr int kMeshDescriptor = 0;
constexpr int kAnswerDescriptor = 3;
constexpr int kCompanionDescriptor = 4;

std::string read_all(int descriptor) {
  struct stat file {};
  if (fstat(descriptor, &file) != 0) throw MeshError("the file's size cannot be told");
  std::string bytes(static_cast<std::size_t>(file.st_size), '\0');
  std::size_t size = 0;
  while (size < bytes.size()) {
    const ssize_t count = read(descriptor, &bytes[size], bytes.size() - size);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) throw MeshError("the file cannot be read to its end");
    size += static_cast<std::size_t>(count);
  }
  return bytes;
}

struct Arguments {
  std::string name;
  rlim_t memory_bytes, processor_seconds;
};

std::vector<char> answer_to(const Arguments& arguments) {
  try {
    limit_resources(arguments.memory_bytes, arguments.processor_seconds);
    confine();
    const std::string companion = read_all(kCompanionDescriptor);
    return encode_mesh(read_mesh_bytes(read_all(kMeshDescriptor), arguments.name, companion));
  } catch (const MeshError& error) {
    return encode_mesh_error(error.what());
  } catch (const std::bad_alloc&) {
    return encode_mesh_error("reading it takes more than " + std::to_string(arguments.memory_bytes >> 20) +
                             " MB of memory; the file is damaged, or make the mesh coarser");
  } catch (const std::exception& error) {
    return encode_mesh_error(std::string("reading it failed: ") + error.what());
  }
}

bool write_all(std::span<const char> bytes) {
  while (!bytes.empty()) {
    const ssize_t count = write(kAnswerDescriptor, bytes.data(), bytes.size());
    if (count < 0 && errno != EINTR) return false;
    bytes = bytes.subspan(static_cast<std::size_t>(std::max<ssize_t>(count, 0)));
  }
  return true;
}

}  // namespace
}  // namespace acus

int main(int argc, char** argv) {
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  const bool asked = arguments == std::vector<std::string>{"--help"};
  if (asked || arguments.size() != 3) {
    static_cast<void>(std::fputs("acus-mesh reads mesh files for the other programs of Acus, which start it\n",
                                 asked ? stdout : stderr));
    return asked ? 0 : 2;
  }
  const bool written =
      acus::write_all(acus::answer_to({arguments[0], std::stoull(arguments[1]), std::stoull(arguments[2])}));
  _exit(written ? 0 : 1);  // what sanitizers do at an orderly end is refused by now
}
