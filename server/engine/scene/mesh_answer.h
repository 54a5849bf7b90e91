// SPDX-License-Identifier: GPL-3.0-or-later
// What acus-mesh, the program that reads mesh files with Gmsh, tells the program that started it: a mesh as it is
// in the file, or why there is none. Gmsh may have been misled by a damaged file, so nothing in it is trusted.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace acus {

// tag_names of a TetrahedralMesh has an entry for each number up to the largest.
constexpr std::int32_t kMaxPhysicalGroup = 100'000;

constexpr std::uint64_t kMaxMeshNodes = 2'500'000;
constexpr std::uint64_t kMaxMeshTetrahedra = 12'000'000;
constexpr std::uint64_t kMaxGroupName = 1'000;   // bytes
constexpr std::uint64_t kMaxGroupNames = 1'000;  // groups with a name
constexpr std::uint64_t kMaxAnswerText = 1'000;  // bytes of an error

struct RawMesh {
  std::vector<double> coordinates;       // 3 per node, finite, in the file's unit
  std::vector<std::int32_t> tetrahedra;  // 4 node indices per tetrahedron, of either handedness
  std::vector<std::int32_t> groups;      // physical group per tetrahedron, 0 where there is none
  std::vector<std::string> group_names;  // name of group i, empty where it has none; an entry up to the largest group
};

// An answer of more bytes is wrong.
constexpr std::uint64_t kMaxAnswerBytes = 64 + kMaxAnswerText + kMaxMeshNodes * 3 * sizeof(double) +
                                          kMaxMeshTetrahedra * 5 * sizeof(std::int32_t) +
                                          kMaxGroupNames * (16 + kMaxGroupName);

// The answer's bytes. Throws MeshError for a mesh above the limits.
std::vector<char> encode_mesh(const RawMesh& mesh);
std::vector<char> encode_mesh_error(const std::string& what);

// The mesh, with sizes that fit together, indices and groups in range, and finite coordinates. Throws MeshError with
// the text of an error, or if the bytes are no complete answer.
RawMesh decode_mesh_answer(std::span<const char> bytes);

}  // namespace acus
