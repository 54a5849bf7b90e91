// SPDX-License-Identifier: GPL-3.0-or-later
// What a mesh file holds, in one form for all formats: nodes and volume elements by the file's own numbers, with their
// places for errors. Of elements without a volume only the count is kept.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "server/engine/mesh_files/file_text.h"
#include "server/engine/models/geometry/mesh_group.h"

namespace acus {

// Corners in the order that all formats share: of a face, then along its outline; a pyramid's apex and the other face
// of prism and hexahedron come last.
enum class Shape : std::uint8_t { tetrahedron, pyramid, prism, hexahedron };

constexpr std::size_t corner_count(Shape shape) {
  constexpr std::array<std::size_t, 4> corners{4, 5, 6, 8};
  return corners[static_cast<std::size_t>(shape)];
}

// An element type of a format. Its nodes are read in the file's order; `order` picks from them the corners and, of a
// quadratic tetrahedron, the nodes in the middle of the edges 01, 12, 02, 03, 13, 23. Other nodes are left out.
struct ElementType {
  Shape shape;
  std::size_t nodes;
  std::array<std::uint8_t, 10> order{0, 1, 2, 3, 4, 5, 6, 7, 8, 9};
  bool quadratic() const { return nodes > corner_count(shape); }
  bool has_middles() const { return shape == Shape::tetrahedron && nodes == 10; }
};

constexpr std::size_t kNoPlace = static_cast<std::size_t>(-1);  // in formats whose elements are numbers of arrays

struct MeshNode {
  std::int64_t number;
  std::size_t at;  // byte of the file
  std::array<double, 3> x;
};

struct MeshElement {
  std::int64_t number;  // 0 in formats without numbers
  std::size_t at;       // byte of the file, or kNoPlace
  Shape shape;
  bool quadratic;
  bool has_middles;
  std::array<std::int64_t, 10> nodes;  // corners, then the middles of a tetrahedron's edges

  std::span<std::int64_t> used_nodes() { return std::span(nodes).first(has_middles ? 10 : corner_count(shape)); }
};

struct MeshContents {
  std::string format;  // "Gmsh 2.2"
  std::vector<MeshNode> nodes;
  std::vector<MeshElement> elements;
  std::vector<MeshGroup> groups;                // of elements
  std::map<std::string, std::size_t> left_out;  // elements without volume or place: how many of each kind
  std::vector<std::string> remarks;             // what else of the file was left out

  // `nodes` has as many as the type.
  void add_element(const ElementType& type, std::int64_t number, std::size_t at, std::span<const std::int64_t> nodes);
};

// Finds or makes groups while elements are read.
class GroupMaker {
 public:
  explicit GroupMaker(std::vector<MeshGroup>& groups) : groups_(groups) {}
  MeshGroup& of(const std::string& array, std::int64_t number);
  MeshGroup& of(const std::string& name);

 private:
  std::vector<MeshGroup>& groups_;
  std::map<std::pair<std::string, std::int64_t>, std::size_t> numbered_;
  std::map<std::string, std::size_t> named_;
};

// Groups of the values in `values`, one per element of `elements`; a remark where they are too many to be regions.
void add_groups_of_array(const std::string& array, std::span<const std::int64_t> values, MeshContents& contents);

}  // namespace acus
