// SPDX-License-Identifier: GPL-3.0-or-later
// What acus-mesh, the program that reads mesh files, tells the program that started it: the tetrahedra of the file, or
// why there are none. A damaged file may have misled it, so nothing in it is trusted.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "server/engine/models/geometry/mesh_group.h"

namespace acus {

constexpr std::uint64_t kMaxMeshNodes = 2'500'000;
constexpr std::uint64_t kMaxMeshTetrahedra = 12'000'000;
constexpr std::uint64_t kMaxGroups = 5'000;
constexpr std::uint64_t kMaxGroupMembers = 4 * kMaxMeshTetrahedra;  // of all groups together
constexpr std::uint64_t kMaxNotes = 100;
constexpr std::uint64_t kMaxAnswerText = 1'000;  // bytes of a name, a note, an error

struct RawMesh {
  std::string format;                    // "Gmsh 2.2"
  std::vector<double> coordinates;       // 3 per node, finite, in the file's unit
  std::vector<std::int32_t> tetrahedra;  // 4 node indices per tetrahedron, of either handedness
  std::vector<MeshGroup> groups;         // none is empty
  std::vector<std::string> notes;        // what was split or left out
};

// An answer of more bytes is wrong.
constexpr std::uint64_t kMaxAnswerBytes = 64 + (kMaxNotes + 2 + 3 * kMaxGroups) * (kMaxAnswerText + 16) +
                                          kMaxMeshNodes * 3 * sizeof(double) +
                                          (kMaxMeshTetrahedra * 4 + kMaxGroupMembers) * sizeof(std::int32_t);

// The answer's bytes. Throws MeshError for a mesh above the limits.
std::vector<char> encode_mesh(const RawMesh& mesh);
std::vector<char> encode_mesh_error(const std::string& what);

// The mesh, with sizes that fit together, indices in range, and finite coordinates. Throws MeshError with
// the text of an error, or if the bytes are no complete answer.
RawMesh decode_mesh_answer(std::span<const char> bytes);

}  // namespace acus
