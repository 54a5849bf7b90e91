// SPDX-License-Identifier: GPL-3.0-or-later
// https://wias-berlin.de/software/tetgen/fformats.html. Numbers begin at 0 or 1, as the first node's says.
#include "server/engine/mesh_files/formats/readers.h"
#include "server/engine/models/geometry/tetrahedral_mesh.h"

namespace acus {
namespace {

void read_tetgen_nodes(std::string_view bytes, MeshContents& contents) {
  FileText file(bytes, '#');
  const std::size_t nodes = file.count("the number of nodes");
  if (file.count("the dimension") != 3) file.fail("expected dimension 3");
  const std::size_t attributes = file.count("the number of attributes"), markers = file.count("the number of markers");
  file.expect_line_end("the number of markers");
  for (std::size_t i = 0; i < nodes; ++i) {
    const std::int64_t number = file.integer("a node number");
    const double x = file.real("a coordinate"), y = file.real("a coordinate"), z = file.real("a coordinate");
    for (std::size_t a = 0; a < attributes + markers; ++a) file.real("an attribute");
    file.expect_line_end("a node");
    const std::int64_t first = contents.nodes.empty() ? number : contents.nodes.front().number;
    if (number != first + static_cast<std::int64_t>(i) || first < 0 || first > 1)
      file.fail("node number " + std::to_string(number) + ": expected numbers one after the other from 0 or 1");
    contents.nodes.push_back({number, 0, {x, y, z}});
  }
  if (!file.peek().empty())
    throw MeshError("the file announces " + std::to_string(nodes) + " nodes and has more: " + in_quotes(file.peek()));
}

}  // namespace

MeshContents read_tetgen(std::string_view elements, std::string_view nodes) {
  MeshContents contents;
  contents.format = "TetGen";
  try {
    read_tetgen_nodes(nodes, contents);
  } catch (const MeshError& error) {
    throw MeshError(std::string("in the .node file: ") + error.what());
  }
  FileText file(elements, '#');
  GroupMaker groups(contents.groups);
  const std::size_t tetrahedra = file.count("the number of tetrahedra"),
                    corners = file.count("the nodes of a tetrahedron");
  if (corners != 4 && corners != 10)
    file.fail("expected 4 or 10 nodes of a tetrahedron, found " + std::to_string(corners));
  const bool has_region = file.count("the number of attributes") > 0;
  file.expect_line_end("the number of attributes");
  std::vector<std::int64_t> its_nodes(corners);
  for (std::size_t i = 0; i < tetrahedra; ++i) {
    const std::int64_t number = file.integer("the number of a tetrahedron");
    const std::size_t at = file.word_at();
    for (std::int64_t& node : its_nodes) node = file.integer("a node of a tetrahedron");
    if (has_region) {
      const double region = file.real("a region attribute");
      groups.of("", static_cast<std::int64_t>(region)).members.push_back(static_cast<int>(i));
    }
    file.expect_line_end("a tetrahedron");
    // TetGen's order of the nodes between corners: edges 23, 03, 01, 12, 13, 02.
    contents.add_element({Shape::tetrahedron, corners, {0, 1, 2, 3, 6, 7, 9, 5, 8, 4}}, number, at, its_nodes);
  }
  if (!file.peek().empty())
    throw MeshError("the file announces " + std::to_string(tetrahedra) +
                    " tetrahedra and has more: " + in_quotes(file.peek()));
  return contents;
}

}  // namespace acus
