// SPDX-License-Identifier: GPL-3.0-or-later
// No element is lost without a word: what a file announces is what it holds, and what it holds is in the mesh.
#include <doctest/doctest.h>

#include "tests/mesh_files/read_text.h"
#include "tests/support/mesh_files.h"

namespace acus {
namespace {

using test::error_of;
using test::MeshFile;
using test::read_text;

// Gmsh 2.2 with the given section of elements, which begins in line 12, below five nodes.
std::string msh(const std::string& elements,
                const std::string& nodes = "5\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 1 1 1\n") {
  return "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n" + nodes + "$EndNodes\n$Elements\n" + elements +
         "$EndElements\n";
}

const std::string kBoth = "1 4 2 1 1 1 2 3 4\n2 4 2 1 1 5 2 3 4\n";

}  // namespace

TEST_CASE("a file that holds more or less than it announces is refused, with the line") {
  CHECK(error_of(msh("2\n" + kBoth)) == "no error");
  CHECK(error_of(msh("1\n" + kBoth)) ==
        "line 15: expected $EndElements, since $Elements in line 12 announces no more, found \"2\"");
  CHECK(error_of(msh("3\n" + kBoth)) == "line 16: expected an element number, found \"$EndElements\"");
  CHECK(error_of(msh("2\n" + kBoth, "4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 1 1 1\n")) ==
        "line 10: expected $EndNodes, since $Nodes in line 4 announces no more, found \"5\"");
  CHECK(error_of("MeshVersionFormatted 1\nDimension 3\nVertices\n4\n0 0 0 1\n1 0 0 1\n0 1 0 1\n0 0 1 "
                 "1\nTetrahedra\n1\n1 2 3 4 "
                 "1\n4 2 3 1 1\nEnd\n") ==
        "line 12: expected a section, found \"4\"; the section before it announces fewer entries than it has");
  CHECK(error_of(
            "# vtk DataFile Version 3.0\nx\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 float\n0 0 0 1 0 0 0 1 0 0 0 1\n"
            "CELLS 1 10\n4 0 1 2 3\n4 3 1 2 0\nCELL_TYPES 1\n10\n") == "CELLS announces 1 cells, its numbers are 2");
}

TEST_CASE("Gmsh 4.1: blocks hold as many as the section announces") {
  std::string text = test::kMsh4.text;
  text.replace(text.find("$Elements\n1 1 1 1"), 17, "$Elements\n1 2 1 2");
  CHECK(error_of(text).ends_with("$Elements announces 2 elements, its blocks hold 1"));
}

TEST_CASE("a number that stands twice is refused, with both lines") {
  CHECK(error_of(msh("2\n1 4 2 1 1 1 2 3 4\n1 4 2 1 1 5 2 3 4\n")) ==
        "line 15: element number 1 stands twice, first in line 14; number elements once each");
  CHECK(error_of("GRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nGRID,3,,0.,1.,0.\nGRID,4,,0.,0.,1.\nCTETRA,1,7,1,2,3,4\n"
                 "CTETRA,1,8,1,2,3,4\n") ==
        "line 6: element number 1 stands twice, first in line 5; number elements once each");
  CHECK(error_of("*NODE\n1,0,0,0\n2,1,0,0\n3,0,1,0\n4,0,0,1\n*ELEMENT,TYPE=C3D4\n7,1,2,3,4\n7,1,2,4,3\n") ==
        "line 8: element number 7 stands twice, first in line 7; number elements once each");
  const std::string twice = "5\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n4 1 1 1\n";
  CHECK(error_of(msh("1\n1 4 2 1 1 1 2 3 4\n", twice)) ==
        "line 10: node 4 stands twice, first in line 9, at another place; number nodes once each");
  const std::string same = "5\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n4 0 0 1\n";
  CHECK(error_of(msh("1\n1 4 2 1 1 1 2 3 4\n", same)) == "no error");
}

TEST_CASE("numbers begin at 1 where a format says so") {
  CHECK(error_of(msh("1\n1 4 2 1 1 1 2 3 4\n", "5\n0 0 0 0\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n")) ==
        "line 6: node number 0: numbers begin at 1");
  CHECK(error_of("MeshVersionFormatted 1\nDimension 3\nVertices\n4\n0 0 0 1\n1 0 0 1\n0 1 0 1\n0 0 1 "
                 "1\nTetrahedra\n1\n0 1 2 3 1\n") == "line 11: the element names node 0: numbers begin at 1");
  CHECK(error_of("*NODE\n0,0,0,0\n") == "line 2: node number 0: numbers begin at 1");
  CHECK(error_of("GRID,0,,0.,0.,0.\n") == "line 1: node number 0: numbers begin at 1");
}

TEST_CASE("an element whose node is not there is refused, with its line") {
  CHECK(error_of(msh("1\n1 4 2 1 1 1 2 3 9\n")) == "line 14: the element names node 9, which is not in the file");
  CHECK(error_of(
            "# vtk DataFile Version 3.0\nx\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 float\n0 0 0 1 0 0 0 1 0 0 0 1\n"
            "CELLS 1 5\n4 0 1 2 4\nCELL_TYPES 1\n10\n") == "cell 0 names point 4, expected 0 to 3");
}

TEST_CASE("an element with more or fewer nodes than its type has is refused") {
  CHECK(error_of(msh("1\n1 4 2 1 1 1 2 3 4 5\n")) ==
        "line 14: expected the end of the line after the element's nodes, found \"5\"");
  CHECK(error_of(msh("1\n1 4 2 1 1 1 2 3\n")).starts_with("line 15: expected a node of the element"));
  CHECK(error_of("*NODE\n1,0,0,0\n2,1,0,0\n3,0,1,0\n4,0,0,1\n*ELEMENT,TYPE=C3D4\n7,1,2,3,4,1\n") ==
        "line 7: the element has 5 nodes, expected 4");
}

// Formats that announce counts, or end with a mark; others tell that they lack it.
TEST_CASE("a file that is cut off anywhere is refused, or nothing of the mesh is behind the cut") {
  const std::vector<MeshFile> announced{test::kMsh1,       test::kMsh2,        test::kMsh2Binary, test::kMsh4,
                                        test::kMsh4Binary, test::kVtk,         test::kVtkBinary,  test::kUnv,
                                        test::kMedit,      test::kMeditBinary, test::kVtk5,       test::kVtu,
                                        test::kVtuAppended};
  for (const MeshFile& file : announced) {
    CAPTURE(file.name);
    const RawMesh whole = read_text(file.text);
    for (std::size_t size = 0; size < file.text.size(); ++size) {
      CAPTURE(size);
      try {
        const RawMesh cut = read_text(file.text.substr(0, size));
        CHECK(cut.tetrahedra == whole.tetrahedra);
        CHECK(cut.coordinates == whole.coordinates);
      } catch (const MeshError&) {
      }
    }
  }
  CHECK(read_text(test::kNastran.text.substr(0, test::kNastran.text.find("ENDDATA"))).notes ==
        std::vector<std::string>{"no ENDDATA: the file may be cut off"});
}

TEST_CASE("elements without volume are counted in a note") {
  const RawMesh mesh = read_text(msh("4\n1 2 2 9 1 1 2 3\n2 2 2 9 1 1 2 4\n3 15 2 9 1 1\n4 4 2 1 1 1 2 3 4\n"));
  CHECK(mesh.notes == std::vector<std::string>{"not needed: 1 points, 2 triangles"});
  CHECK(mesh.tetrahedra.size() == 4);
}

}  // namespace acus
