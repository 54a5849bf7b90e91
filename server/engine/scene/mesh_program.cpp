// SPDX-License-Identifier: GPL-3.0-or-later
// acus-mesh: reads one mesh file with Gmsh and answers in the layout of mesh_answer.h. Started by mesh_process.cpp with
// the mesh on standard input and a pipe for the answer; the only place that knows Gmsh.
//
//   acus-mesh FOLDER NAME MEMORY_BYTES PROCESSOR_SECONDS
//
// FOLDER holds nothing but NAME, a link to standard input. So Gmsh finds no NAME.opt, which it would run as a script.
// What a script could still reach is closed, too (mesh_confinement.h).
#include <fcntl.h>
#include <gmsh.h>
#include <sys/mman.h>
#include <sys/sendfile.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <new>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "server/engine/models/tetrahedral_mesh.h"
#include "server/engine/scene/mesh_answer.h"
#include "server/engine/scene/mesh_confinement.h"

namespace acus {
namespace {

constexpr int kMeshDescriptor = 0;
constexpr int kAnswerDescriptor = 3;

constexpr int kLinearTetrahedron = 4;  // Gmsh's number for the element type

// Gmsh runs a .msh file that begins otherwise as a script.
constexpr std::array<std::string_view, 3> kMshOpenings{"$MeshFormat", "$NOD", "$Comments"};

// Nobody changes the copy between the check of its first line and Gmsh.
void copy_mesh() {
  struct stat file {};
  const int copy = memfd_create("mesh", MFD_CLOEXEC);
  if (copy < 0 || fstat(kMeshDescriptor, &file) != 0) throw MeshError("no copy of the file can be made");
  for (off_t left = file.st_size; left > 0;) {
    const ssize_t count = sendfile(copy, kMeshDescriptor, nullptr, static_cast<std::size_t>(left));
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) throw MeshError("the file cannot be read to its end");
    left -= count;
  }
  dup2(copy, kMeshDescriptor);
  close(copy);
  lseek(kMeshDescriptor, 0, SEEK_SET);
}

template <std::size_t n>
std::string join(const std::array<std::string_view, n>& words) {
  std::string text;
  for (const std::string_view word : words) text.append(text.empty() ? "" : ", ").append(word);
  return text;
}

void check_opening() {
  std::string start(16, '\0');
  if (pread(kMeshDescriptor, start.data(), start.size(), 0) < 0) throw MeshError("the file cannot be read");
  const auto opens = [&start](std::string_view opening) { return start.rfind(opening, 0) == 0; };
  if (std::any_of(kMshOpenings.begin(), kMshOpenings.end(), opens)) return;
  throw MeshError("expected a Gmsh file that starts with one of " + join(kMshOpenings));
}

// Gmsh without configuration files and without terminal output.
void start_gmsh() {
  gmsh::initialize(0, nullptr, false);
  gmsh::option::setNumber("General.Terminal", 0);
  gmsh::logger::start();
}

// Gmsh carries on after some errors and leaves them in its log; here each is the end.
void merge_file(const std::string& path) {
  gmsh::merge(path);
  std::vector<std::string> log;
  gmsh::logger::get(log);
  for (const std::string& line : log) {
    if (line.rfind("Error", 0) == 0) throw MeshError("Gmsh says: " + line);
  }
}

// The one physical group of a volume, 0 if it has none.
int physical_group(int volume) {
  std::vector<int> groups;
  gmsh::model::getPhysicalGroupsForEntity(3, volume, groups);
  if (groups.empty()) return 0;
  if (groups.size() > 1) {
    throw MeshError("volume " + std::to_string(volume) + " lies in physical groups " + std::to_string(groups[0]) +
                    " and " + std::to_string(groups[1]) + "; a tetrahedron may belong to one at most");
  }
  if (groups[0] < -kMaxPhysicalGroup || groups[0] > kMaxPhysicalGroup) {
    throw MeshError("physical group " + std::to_string(groups[0]) + " is numbered above " +
                    std::to_string(kMaxPhysicalGroup));
  }
  return std::abs(groups[0]);
}

// Gmsh's elements as they stand in the file: four node numbers ("tags") and a physical group each.
struct RawElements {
  std::vector<std::size_t> node_tags;  // 4 per tetrahedron
  std::vector<int> groups;             // one per tetrahedron
};

void append_volume(int volume, RawElements& raw) {
  std::vector<int> types;
  std::vector<std::vector<std::size_t>> elements, nodes;
  gmsh::model::mesh::getElements(types, elements, nodes, 3, volume);
  const int group = physical_group(volume);
  for (std::size_t i = 0; i < types.size(); ++i) {
    if (types[i] != kLinearTetrahedron) {
      throw MeshError("volume " + std::to_string(volume) + " holds elements of Gmsh type " + std::to_string(types[i]) +
                      "; expected linear tetrahedra (type 4) only");
    }
    raw.node_tags.insert(raw.node_tags.end(), nodes[i].begin(), nodes[i].end());
    raw.groups.insert(raw.groups.end(), elements[i].size(), group);
  }
}

RawElements read_elements() {
  RawElements raw;
  gmsh::vectorpair volumes;
  gmsh::model::getEntities(volumes, 3);
  for (const auto& [dimension, volume] : volumes) append_volume(volume, raw);
  if (raw.groups.empty()) throw MeshError("the file holds no tetrahedra");
  return raw;
}

// Ascending numbers of the nodes that tetrahedra use: surface meshes and construction points leave others.
std::vector<std::size_t> used_node_tags(const RawElements& raw) {
  std::vector<std::size_t> used = raw.node_tags;
  std::sort(used.begin(), used.end());
  used.erase(std::unique(used.begin(), used.end()), used.end());
  return used;
}

// Position of a number in the ascending list, or -1.
int index_of(const std::vector<std::size_t>& tags, std::size_t tag) {
  const auto found = std::lower_bound(tags.begin(), tags.end(), tag);
  return found != tags.end() && *found == tag ? static_cast<int>(found - tags.begin()) : -1;
}

std::vector<double> read_nodes(const std::vector<std::size_t>& used) {
  std::vector<std::size_t> tags;
  std::vector<double> coordinates, parameters;
  gmsh::model::mesh::getNodes(tags, coordinates, parameters);
  std::vector<double> nodes(3 * used.size());
  std::vector<bool> found(used.size(), false);
  for (std::size_t i = 0; i < tags.size(); ++i) {
    const int node = index_of(used, tags[i]);
    if (node < 0) continue;
    std::copy_n(&coordinates[3 * i], 3, &nodes[3 * static_cast<std::size_t>(node)]);
    found[node] = true;
  }
  const auto missing = std::find(found.begin(), found.end(), false);
  if (missing != found.end()) {
    throw MeshError("node " + std::to_string(used[missing - found.begin()]) + " is used but not listed");
  }
  return nodes;
}

std::vector<std::string> read_group_names(const std::vector<int>& groups) {
  std::vector<std::string> names(*std::max_element(groups.begin(), groups.end()) + 1);
  gmsh::vectorpair known;
  gmsh::model::getPhysicalGroups(known, 3);
  for (const auto& [dimension, group] : known) {
    if (group >= 0 && group < static_cast<int>(names.size())) gmsh::model::getPhysicalName(3, group, names[group]);
  }
  return names;
}

RawMesh convert(const RawElements& raw) {
  const std::vector<std::size_t> used = used_node_tags(raw);
  RawMesh mesh;
  mesh.coordinates = read_nodes(used);
  mesh.groups = raw.groups;
  mesh.group_names = read_group_names(raw.groups);
  mesh.tetrahedra.reserve(raw.node_tags.size());
  for (const std::size_t tag : raw.node_tags) mesh.tetrahedra.push_back(index_of(used, tag));
  return mesh;
}

std::vector<char> read_mesh(const std::string& folder, const std::string& name, rlim_t memory, rlim_t seconds) {
  if (chdir(folder.c_str()) != 0) throw MeshError("the folder " + folder + " is not there");
  limit_resources(memory, seconds);
  copy_mesh();
  if (name.ends_with(".msh")) check_opening();
  confine();
  start_gmsh();
  merge_file(name);
  return encode_mesh(convert(read_elements()));
}

// What it reads may come from a damaged file, whichever of Gmsh's parts it ends in.
std::vector<char> answer_of(const std::vector<std::string>& arguments) {
  const rlim_t memory = std::stoull(arguments[2]);
  try {
    return read_mesh(arguments[0], arguments[1], memory, std::stoull(arguments[3]));
  } catch (const MeshError& error) {
    return encode_mesh_error(error.what());
  } catch (const std::bad_alloc&) {
    return encode_mesh_error("reading it takes more than " + std::to_string(memory >> 20) +
                             " MB of memory; the file is damaged, or make the mesh coarser");
  } catch (const std::exception& error) {
    return encode_mesh_error(std::string("Gmsh says: ") + error.what());
  } catch (const std::string& error) {  // what Gmsh's API throws
    return encode_mesh_error("Gmsh says: " + error);
  } catch (...) {
    return encode_mesh_error("Gmsh gave up on it without a word why");
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
  if (asked || arguments.size() != 4) {
    static_cast<void>(std::fputs("acus-mesh reads mesh files for the other programs of Acus, which start it\n",
                                 asked ? stdout : stderr));
    return asked ? 0 : 2;
  }
  const bool written = acus::write_all(acus::answer_of(arguments));
  _exit(written ? 0 : 1);  // Gmsh's destructors have nothing to add
}
