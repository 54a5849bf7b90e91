// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/runtime/mesh_summary.h"

#include <doctest/doctest.h>

#include "server/engine/scene/scene.h"
#include "server/runtime/scene_summary.h"
#include "tests/support/temporary_folder.h"

namespace acus {
namespace {

// A cube and two prisms beside it, with a label of each.
const char* const kCells =
    "# vtk DataFile Version 3.0\nx\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 12 double\n"
    "0 0 0 50 0 0 50 50 0 0 50 0 0 0 50 50 0 50 50 50 50 0 50 50 100 0 0 100 50 0 100 0 50 100 50 50\n"
    "CELLS 3 23\n8 0 1 2 3 4 5 6 7\n6 1 8 9 5 10 11\n6 1 9 2 5 11 6\nCELL_TYPES 3\n12\n13\n13\n"
    "CELL_DATA 3\nSCALARS label int\nLOOKUP_TABLE default\n4\n7\n9\n";

Simulation with_regions(const std::string& regions) {
  const TemporaryFolder folder;
  folder.write("a.vtk", kCells);
  return Simulation(parse_scene(
      "acus_scene: 1\ntissue:\n  mesh: {gmsh: {file: a.vtk, metres_per_unit: 0.001}}\n  regions:\n" + regions +
          "  fixed: [{half_space: {point: [0, 0, 0]}}]\nneedles:\n"
          "  - base: {position: [0.02, 0.02, 0.3], orientation: [0.7071068, 0, 0.7071068, 0]}\n",
      "scene.yaml", folder.path()));
}

std::string warnings_of(const Simulation& simulation) {
  SceneWarnings found;
  warn_of_unnamed_groups(simulation, found);
  return found.empty() ? "" : found[0].text;
}

}  // namespace

TEST_CASE("the check says how a mesh file was read, and which regions its groups are") {
  const Simulation simulation = with_regions("    - name: fat\n    - {name: tumour, physical_group: label 7}\n");
  const std::string text = summarise_mesh_file(simulation);
  CHECK(text ==
        "mesh file\n"
        "  read as VTK legacy 3.0\n"
        "  2 prisms, 1 hexahedron split into 12 tetrahedra\n"
        "  groups     tetrahedra  regions\n"
        "    label 4  6           none\n"
        "    label 7  3           tumour\n"
        "    label 9  3           none\n");
  CHECK(summarise(simulation).find(text) != std::string::npos);
  CHECK(warnings_of(simulation) ==
        "no region names these groups of the mesh file, so that nothing tells them apart: label 4, label 9; give them "
        "regions with physical_group");
}

TEST_CASE("where regions name all groups of a mesh file but the background, nothing is warned of") {
  const std::string two = "    - {name: vessel, physical_group: 7}\n    - {name: tumour, physical_group: 9}\n";
  CHECK(warnings_of(with_regions("    - {name: fat, physical_group: 4}\n" + two)) == "");
  CHECK(warnings_of(with_regions("    - name: fat\n" + two)) == "");
  CHECK(warnings_of(with_regions("    - name: fat\n")).find("label 4, label 7, label 9") != std::string::npos);
}

TEST_CASE("a scene without a mesh file has no such part") {
  CHECK(summarise_mesh_file(Simulation(
            parse_scene("acus_scene: 1\nneedles:\n  - base: {position: [0, 0, 0.3]}\n", "scene.yaml", ""))) == "");
}

}  // namespace acus
