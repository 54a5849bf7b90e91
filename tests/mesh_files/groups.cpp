// SPDX-License-Identifier: GPL-3.0-or-later
// What regions can select by: the groups of each format.
#include <doctest/doctest.h>

#include "tests/mesh_files/read_text.h"
#include "tests/support/mesh_files.h"

namespace acus {
namespace {

using test::find_group;
using test::MeshFile;
using test::read_text;

std::vector<std::string> labels(const RawMesh& mesh) {
  std::vector<std::string> all;
  for (const MeshGroup& group : mesh.groups) all.push_back(group.label());
  return all;
}

}  // namespace

TEST_CASE("every format tells its groups") {
  const std::vector<std::pair<MeshFile, std::vector<std::string>>> expected{
      {test::kMsh1, {"7"}},         {test::kMsh2, {"7 (liver)"}}, {test::kMsh2Binary, {"7"}},
      {test::kMsh4, {"7 (liver)"}}, {test::kMsh4Binary, {"7"}},   {test::kMedit, {"7"}},
      {test::kMeditBinary, {"7"}},  {test::kNastran, {"7"}},      {test::kUnv, {"material 7", "property 1"}},
      {test::kVtk5, {"region 7"}},  {test::kVtu, {"region 7"}},   {test::kAbaqus, {"liver"}},
  };
  for (const auto& [file, names] : expected) {
    CAPTURE(file.name);
    CHECK(labels(read_text(file.text)) == names);
  }
}

TEST_CASE("a group is found by name, by number, and by array and number") {
  const MeshGroup named{"", 3, "skull", {0}}, of_array{"label", -2, "", {0}}, of_name{"", std::nullopt, "SET-1", {0}};
  CHECK(named.answers_to("skull"));
  CHECK(named.answers_to("3"));
  CHECK_FALSE(named.answers_to("03"));
  CHECK_FALSE(named.answers_to(""));
  CHECK(of_array.answers_to("-2"));
  CHECK(of_array.answers_to("label -2"));
  CHECK_FALSE(of_array.answers_to("label"));
  CHECK_FALSE(of_array.answers_to(""));
  CHECK(of_name.answers_to("SET-1"));
  CHECK_FALSE(of_name.answers_to("1"));
}

TEST_CASE("a volume may lie in several physical groups") {
  std::string text = test::kMsh4.text;
  text.replace(text.find("1 0 0 0 1 1 1 1 7 0"), 19, "1 0 0 0 1 1 1 2 7 -8 0");
  CHECK(labels(read_text(text)) == std::vector<std::string>{"7 (liver)", "8"});
}

TEST_CASE("named groups of a universal file") {
  const std::string groups =
      "    -1\n  2467\n         1         0         0         0         0         0         0         2\nleft lobe\n"
      "         8         1         0         0         7         1         0         0\n    -1\n";
  const RawMesh mesh = read_text(test::kUnv.text + groups);
  CHECK(find_group(mesh, "left lobe")->members == std::vector<int>{0});
}

TEST_CASE("Abaqus' element sets may overlap, hold others, and be spelt in capitals") {
  const std::string nodes = "*NODE\n1,0,0,0\n2,1,0,0\n3,0,1,0\n4,0,0,1\n5,1,1,1\n6,3,3,3\n";
  const RawMesh mesh =
      read_text(nodes +
                "*ELEMENT, TYPE=C3D4, ELSET=one\n10,1,2,3,4\n*ELEMENT, TYPE=C3D4, ELSET=Two\n20,2,3,4,5\n"
                "30,2,3,5,6\n*ELSET, ELSET=both\nONE, two\n*ELSET, ELSET=range, GENERATE\n20, 40, 10\n"
                "*ELSET, ELSET=listed\n10,\n30, 99\n");
  CHECK(find_group(mesh, "one")->members == std::vector<int>{0});
  CHECK(find_group(mesh, "Two")->members == std::vector<int>{1, 2});
  CHECK(find_group(mesh, "both")->members == std::vector<int>{0, 1, 2});
  CHECK(find_group(mesh, "range")->members == std::vector<int>{1, 2});
  CHECK(find_group(mesh, "listed")->members == std::vector<int>{0, 2});
}

TEST_CASE("a cell array with more values than there are tissues is no group") {
  std::string points, cells, types, ids;
  constexpr int kCells = 1001;
  for (int i = 0; i < kCells; ++i) {
    cells += "4 0 1 2 3\n";
    types += "10\n";
    ids += std::to_string(i) + "\n";
  }
  const auto of = [](const std::string& word, int count) { return word + " " + std::to_string(count); };
  const RawMesh mesh = read_text(
      "# vtk DataFile Version 3.0\nx\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 float\n"
      "0 0 0 1 0 0 0 1 0 0 0 1\n" +
      of("CELLS", kCells) + of("", 5 * kCells) + "\n" + cells + of("CELL_TYPES", kCells) + "\n" + types +
      of("CELL_DATA", kCells) + "\nSCALARS id int\nLOOKUP_TABLE default\n" + ids);
  CHECK(mesh.groups.empty());
  CHECK(mesh.notes == std::vector<std::string>{"cell array \"id\" has more than 1000 values: too many to be groups"});
}

}  // namespace acus
