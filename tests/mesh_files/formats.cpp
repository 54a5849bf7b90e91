// SPDX-License-Identifier: GPL-3.0-or-later
// Each format, in the forms in which programs write it.
#include <doctest/doctest.h>

#include "tests/mesh_files/read_text.h"
#include "tests/support/mesh_files.h"

namespace acus {
namespace {

using test::error_of;
using test::find_group;
using test::kMeshFiles;
using test::MeshFile;
using test::read_text;

// The unit tetrahedron.
void check_tetrahedron(const RawMesh& mesh) {
  CHECK(mesh.coordinates == std::vector<double>{0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1});
  CHECK(mesh.tetrahedra == std::vector<std::int32_t>{0, 1, 2, 3});
}

}  // namespace

TEST_CASE("every format is told by what the file holds, whatever its name") {
  for (const MeshFile& file : kMeshFiles) {
    for (const char* name : {file.name.c_str(), "mesh", "mesh.vtk", "mesh.msh", "mesh.dat"}) {
      CAPTURE(file.name);
      CAPTURE(name);
      check_tetrahedron(read_text(file.text, name));
    }
  }
}

TEST_CASE("a byte-order mark and empty lines before a file are passed over") {
  for (const MeshFile& file :
       {test::kMsh2, test::kMsh4, test::kVtk5, test::kVtu, test::kMedit, test::kNastran, test::kAbaqus, test::kUnv}) {
    CAPTURE(file.name);
    check_tetrahedron(read_text("\xef\xbb\xbf" + file.text));
  }
}

TEST_CASE("lines may end as Windows ends them") {
  for (const MeshFile& file : {test::kMsh1, test::kMsh2, test::kMsh4, test::kVtk, test::kVtk5, test::kVtu, test::kMedit,
                               test::kNastran, test::kAbaqus, test::kUnv}) {
    CAPTURE(file.name);
    std::string text;
    for (const char c : file.text) text += c == '\n' ? std::string("\r\n") : std::string(1, c);
    check_tetrahedron(read_text(text));
  }
}

TEST_CASE("TetGen's two files are read, whichever is named") {
  const std::string &elements = test::kTetgenElements.text, &nodes = test::kTetgenNodes.text;
  check_tetrahedron(read_mesh_bytes(elements, "a.ele", nodes));
  check_tetrahedron(read_mesh_bytes(nodes, "a.node", elements));
  CHECK(find_group(read_mesh_bytes(elements, "a.ele", nodes), "7")->members == std::vector<int>{0});
  CHECK(error_of(elements, "a.ele") ==
        "a mesh of TetGen is two files of one name, .ele and .node; the .node file is not beside the other one");
}

TEST_CASE("Nastran's cards in small, large and free fields, with numbers as it writes them") {
  const auto read = [](const std::string& grid4, const std::string& tetra) {
    return read_text(
        "BEGIN BULK\nGRID    1               0.0     0.0     0.0\nGRID    2               1.      0.      0.\n"
        "GRID    3               0.      1.      0.\n" +
        grid4 + tetra + "ENDDATA\n");
  };
  const std::string small = "GRID    4               0.      0.      1.0-0\n";
  const std::string large =
      "GRID*                  4                              0.              0.\n*                  1.D+0\n";
  const std::string free = "GRID,4,,.0,0.,+1.0E0\n";
  const std::string in_tabs = "GRID\t4\t\t0.\t0.\t1.\n";
  for (const std::string& grid : {small, large, free, in_tabs})
    for (const char* tetra : {"CTETRA  1       7       1       2       3       4\n", "CTETRA,1,7,1,2,3,4\n",
                              "CTETRA* 1               7               1               2\n*       3               4\n",
                              "ctetra  1       7       1       2       3       4       $ last\n"}) {
      CAPTURE(grid);
      CAPTURE(tetra);
      check_tetrahedron(read(grid, tetra));
    }
  const std::string ten =
      "BEGIN BULK\nGRID,1,,0,0,0\nGRID,2,,1,0,0\nGRID,3,,0,1,0\nGRID,4,,0,0,1\nGRID,5,,.5,0,0\nGRID,6,,.5,.5,0\n"
      "GRID,7,,0,.5,0\nGRID,8,,0,0,.5\nGRID,9,,.5,0,.5\nGRID,10,,0,.5,.5\n";
  for (const char* tetra : {"CTETRA,1,7,1,2,3,4,5,6,7,8,9,10\n", "CTETRA,1,7,1,2,3,4,5,6\n,7,8,9,10\n",
                            "CTETRA,1,7,1,2,3,4,5,6,+C1\n+C1,7,8,9,10\n",
                            "CTETRA  1       7       1       2       3       4       5       6       +1\n+1      7     "
                            "  8       9       10\n"}) {
    CAPTURE(tetra);
    CHECK(read_text(ten + tetra + "ENDDATA\n").notes ==
          std::vector<std::string>{"1 quadratic tetrahedra split into 8 tetrahedra"});
  }
  CHECK(error_of("GRID,1,3,0.,0.,0.\n") ==
        "line 1: nodes in a coordinate system of their own (3) are not read; write them in the basic one");
  CHECK(error_of("GRID,1,,0.,0.,0.\nINCLUDE 'more.bdf'\n") ==
        "line 2: included files are not read; put all cards into one file");
}

TEST_CASE("Abaqus' parts are placed by their instances") {
  const std::string text =
      "*Part, name=Block\n*Node\n10, 0, 0, 0\n20, 1, 0, 0\n30, 0, 1, 0\n40, 0, 0, 1\n*Element, type=C3D4\n5, 10, "
      "20,\n30, 40\n"
      "*Elset, elset=Core, generate\n1, 9, 2\n*End Part\n*Assembly, name=A\n*Instance, name=Left, part=block\n*End "
      "Instance\n"
      "*Instance, name=Right, part=BLOCK\n0, 0, 5\n0, 0, 5, 0, 0, 6, 90\n*End Instance\n"
      "*Elset, elset=far, instance=Right\n 5,\n*End Assembly\n";
  const RawMesh mesh = read_text(text);
  REQUIRE(mesh.coordinates.size() == 24);
  CHECK(std::vector(mesh.coordinates.begin(), mesh.coordinates.begin() + 12) ==
        std::vector<double>{0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1});
  const std::vector<double> turned{0, 0, 5, 0, 1, 5, -1, 0, 5, 0, 0, 6};
  for (std::size_t i = 0; i < 12; ++i) CHECK(mesh.coordinates[12 + i] == doctest::Approx(turned[i]).epsilon(1e-12));
  CHECK(find_group(mesh, "Left.Core")->members == std::vector<int>{0});
  CHECK(find_group(mesh, "Right.far")->members == std::vector<int>{1});
  CHECK(find_group(mesh, "Right")->members == std::vector<int>{1});
  const std::string outside =
      "*Node\n1, 0, 0, 9\n2, 1, 0, 9\n3, 0, 1, 9\n4, 0, 0, 8\n*Element, type=C3D4, elset=Free\n"
      "1, 1, 2, 3, 4\n";
  const std::string alone =
      "*Part, name=Alone" + text.substr(text.find('\n'), text.find("*Elset") - text.find('\n')) + "*End Part\n";
  const RawMesh with_more = read_text(alone + text + outside);
  CHECK(with_more.coordinates.size() == 36);
  CHECK(find_group(with_more, "Right.far")->members == std::vector<int>{1});
  CHECK(find_group(with_more, "Free")->members == std::vector<int>{2});
  CHECK(with_more.notes == std::vector<std::string>{"not needed: 1 elements of part ALONE, which has no instance"});
  CHECK(error_of("*NODE\n1,0,0,0\n*INCLUDE, INPUT=a.inp\n") ==
        "line 3: *INCLUDE is not read; list all nodes and elements in one file");
  CHECK(error_of("*NODE\n1,0,0,0\n*ELEMENT, TYPE=C3D4\n1,1,1,1\n*STEP\n") ==
        "line 4: element 1 has 3 nodes, too few for C3D4");
}

TEST_CASE("legacy VTK: arrays, tables and texts around the cells are passed over") {
  const std::string data =
      "CELL_DATA 1\nSCALARS a float\nLOOKUP_TABLE t\n0.5\nLOOKUP_TABLE t 2\n0 0 0 1\n1 1 1 1\nVECTORS v double\n1 2 "
      "nan\n"
      "FIELD FieldData 3\nmy%20label 1 1 int\n-3\nMETADATA\nINFORMATION 0\n\nnames 1 1 string\na b c\ntensor 9 1 "
      "float\n"
      "1 2 3 4 5 6 7 8 9\nCOLOR_SCALARS c 3\n1 0 0\nPOINT_DATA 4\nSCALARS b int\n1 2 3 4\n";
  const RawMesh mesh = read_text(test::kVtk.text + data);
  check_tetrahedron(mesh);
  REQUIRE(mesh.groups.size() == 1);
  CHECK(mesh.groups[0].label() == "my label -3");
}

TEST_CASE("a partitioned mesh of Gmsh is read in one") {
  std::string text = test::kMsh4.text;
  const std::size_t nodes = text.find("$Nodes");
  text.insert(nodes, "$PartitionedEntities\n1\n0\n0 0 0 1\n9 3 1 1 1 0 0 0 1 1 1 1 5 0\n$EndPartitionedEntities\n");
  text.replace(text.find("3 1 4 1\n"), 8, "3 9 4 1\n");
  const RawMesh mesh = read_text(text);
  check_tetrahedron(mesh);
  REQUIRE(mesh.groups.size() == 1);
  CHECK(mesh.groups[0].label() == "5");
}

}  // namespace acus
