// SPDX-License-Identifier: GPL-3.0-or-later
// From a scene to tetrahedra, regions and fixed nodes; errors lead to the line of the scene that caused them.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "server/engine/scene/scene.h"
#include "tests/support/shared_data.h"
#include "tests/support/temporary_folder.h"

namespace acus {
namespace {

// Two tetrahedra in the physical groups 7 "liver" and 9.
const std::string kTwoGroups = R"($MeshFormat
2.2 0 8
$EndMeshFormat
$PhysicalNames
1
3 7 "liver"
$EndPhysicalNames
$Nodes
5
1 0 0 0
2 1 0 0
3 0 1 0
4 0 0 1
5 1 1 1
$EndNodes
$Elements
2
1 4 2 7 1 1 2 3 4
2 4 2 9 2 5 3 2 4
$EndElements
)";

Scene parse(const std::string& text) { return parse_scene("acus_scene: 1\n" + text, "scene.yaml", ""); }

// The first error on the way from a scene to its fixed nodes.
std::string error_of(const Scene& scene) {
  try {
    const TetrahedralMesh mesh = load_mesh(scene);
    assign_regions(scene, mesh);
    find_fixed_nodes(scene, mesh);
  } catch (const SceneError& error) {
    return error.what();
  }
  return "no error";
}

std::string error_of(const std::string& text) { return error_of(parse(text)); }

// A scene around a mesh file with this content.
struct FileScene {
  TemporaryFolder folder;
  Scene scene;

  FileScene(const std::string& mesh, const std::string& regions) {
    folder.write("a.msh", mesh);
    scene = parse_scene("acus_scene: 1\ntissue:\n  mesh:\n    gmsh: {file: a.msh, metres_per_unit: 0.1}\n" + regions,
                        "scene.yaml", folder.path());
  }
};

int count_of(const std::vector<int>& regions, int region) {
  return static_cast<int>(std::count(regions.begin(), regions.end(), region));
}

}  // namespace

TEST_CASE("the mesh stands at its place in the world") {
  const Scene scene = parse(
      "tissue:\n  mesh: {box: {size: [0.2, 0.4, 0.6], cells: [1, 1, 1]}}\n"
      "  pose: {position: [1, 2, 3], orientation: [0.70710678, 0, 0, 0.70710678]}");
  const TetrahedralMesh mesh = load_mesh(scene);
  // A quarter turn about z exchanges the first two sizes.
  CHECK((mesh.nodes.rowwise().minCoeff() - Vector3(0.8, 1.9, 2.7)).norm() < 1e-8);
  CHECK((mesh.nodes.rowwise().maxCoeff() - Vector3(1.2, 2.1, 3.3)).norm() < 1e-8);
  for (int t = 0; t < mesh.tetrahedron_count(); ++t) CHECK(rest_volume(mesh, t) > 0);
}

TEST_CASE("the last region that selects a tetrahedron has it") {
  const Scene scene = parse(R"(
tissue:
  mesh: {box: {cells: [2, 2, 4]}}
  regions:
    - name: background
    - {name: upper half, box: {min: [-.inf, -.inf, 0]}}
    - {name: top layer, box: {min: [-.inf, -.inf, 0.025]}}
)");
  const std::vector<int> regions = assign_regions(scene, load_mesh(scene));
  CHECK(count_of(regions, 0) == 2 * 2 * 2 * 6);
  CHECK(count_of(regions, 1) == 2 * 2 * 6);
  CHECK(count_of(regions, 2) == 2 * 2 * 6);
}

TEST_CASE("regions by sphere, half-space and cylinder, and by shapes that must agree") {
  const Scene scene = parse(R"(
tissue:
  mesh: {box: {size: [0.4, 0.4, 0.4], cells: [8, 8, 8]}}
  regions:
    - name: background
    - {name: deep, half_space: {point: [0, 0, -0.1], normal: [0, 0, 7]}}
    - {name: ball, sphere: {center: [0.1, 0.1, 0.1], radius: 0.06}}
    - {name: rod, cylinder: {from: [-0.1, -0.1, 0.2], to: [-0.1, -0.1, 0], radius: 0.06}}
    - {name: cap, sphere: {radius: 0.12}, half_space: {normal: [0, 1, 0]}, box: {max: [0, .inf, .inf]}}
)");
  const TetrahedralMesh mesh = load_mesh(scene);
  const std::vector<int> regions = assign_regions(scene, mesh);
  CHECK(count_of(regions, 1) == 8 * 8 * 2 * 6);
  for (int t = 0; t < mesh.tetrahedron_count(); ++t) {
    const auto& c = mesh.tetrahedra[t];
    const Vector3 p = (mesh.nodes.col(c[0]) + mesh.nodes.col(c[1]) + mesh.nodes.col(c[2]) + mesh.nodes.col(c[3])) / 4;
    const bool in_cap = p.norm() < 0.12 && p.x() < 0 && p.y() < 0;
    const bool in_rod = std::hypot(p.x() + 0.1, p.y() + 0.1) < 0.06 && p.z() > 0;
    const bool in_ball = (p - Vector3(0.1, 0.1, 0.1)).norm() < 0.06;
    CHECK(regions[t] == (in_cap ? 4 : in_rod ? 3 : in_ball ? 2 : p.z() < -0.1 ? 1 : 0));
  }
}

TEST_CASE("the boundary of a shape belongs to it") {
  const Cylinder cylinder{{0, 0, 1}, {0, 0, 3}, 0.5};
  CHECK(cylinder.contains({0, 0, 1}));
  CHECK(cylinder.contains({0.5, 0, 3}));
  CHECK_FALSE(cylinder.contains({0, 0, 0.999}));
  CHECK_FALSE(cylinder.contains({0, 0, 3.001}));
  CHECK_FALSE(cylinder.contains({0.36, 0.36, 2}));
  CHECK(cylinder.contains({0.36, 0.36, 2}, 0.01));
  CHECK(cylinder.contains({0, 0, 3.001}, 0.01));
  CHECK(HalfSpace{{0, 0, 1}, {0, 0, 1e3}}.contains({5, 5, 1}));
  CHECK_FALSE(HalfSpace{{0, 0, 1}, {0, 0, 1e3}}.contains({0, 0, 1.02}, 0.01));
  CHECK(Sphere{{1, 0, 0}, 1}.contains({2, 0, 0}));
  CHECK(Volume{}.contains({1e9, 0, 0}));
}

TEST_CASE("an interface has the faces in which its regions meet") {
  const std::string regions =
      "tissue:\n  mesh: {box: {cells: [2, 3, 4]}}\n  regions:\n    - name: bottom\n"
      "    - {name: middle, box: {min: [-.inf, -.inf, -0.025]}}\n    - {name: top, box: {min: [-.inf, -.inf, "
      "0.025]}}\n";
  const Scene scene = parse(regions + "  interfaces: [{between: top, and: middle}, {between: bottom, and: middle}]");
  const TetrahedralMesh mesh = load_mesh(scene);
  // Two triangles for each of the 2 x 3 cells in a layer.
  const std::map<std::pair<int, int>, int> expected{{{0, 1}, 12}, {{1, 2}, 12}};
  CHECK(count_border_faces(mesh, assign_regions(scene, mesh)) == expected);
  CHECK(error_of(regions + "  interfaces:\n    - {between: top, and: bottom}") ==
        "scene.yaml:9:7: tissue.interfaces[0]: expected two regions that share a face of the mesh, found that \"top\" "
        "and \"bottom\" do not touch; leave the entry out or move the regions");
}

TEST_CASE("regions by physical group: name, number, and together with a box") {
  SUBCASE("name and number") {
    const FileScene f(kTwoGroups, "  regions: [{name: a, physical_group: 9}, {name: b, physical_group: liver}]\n");
    CHECK(assign_regions(f.scene, load_mesh(f.scene)) == std::vector<int>{1, 0});
  }
  SUBCASE("number of a group that has a name") {
    const FileScene f(kTwoGroups, "  regions: [{name: a}, {name: b, physical_group: 7}]\n");
    CHECK(assign_regions(f.scene, load_mesh(f.scene)) == std::vector<int>{1, 0});
  }
  SUBCASE("group and box must agree") {
    const FileScene f(kTwoGroups,
                      "  regions: [{name: a}, {name: b, physical_group: 7, box: {min: [0.04, 0.04, 0.04]}}]\n");
    CHECK(
        error_of(f.scene).starts_with("scene.yaml:5:24: tissue.regions[1]: expected a region with tetrahedra, found "
                                      "that \"b\" selects none"));
  }
}

TEST_CASE("regions that do not fit the mesh") {
  const FileScene unknown(kTwoGroups, "  regions: [{physical_group: lung}]\n");
  CHECK(
      error_of(unknown.scene) ==
      "scene.yaml:5:30: tissue.regions[0].physical_group: expected a group of the mesh file (7 (liver), 9), found "
      "\"lung\"");
  CHECK(error_of("tissue: {regions: [{physical_group: 3}]}") ==
        "scene.yaml:2:37: tissue.regions[0].physical_group: expected a group of the mesh file (none), found \"3\"");
  CHECK(error_of("tissue: {mesh: {box: {cells: [2, 2, 2]}}, regions: [{box: {min: [0, 0, 0]}}]}")
            .starts_with("scene.yaml:2:52: tissue.regions: 42 tetrahedra belong to no region, one of them at ["));
  CHECK(error_of("tissue: {regions: [{name: a, box: {max: [0, 0, 0]}}, {name: b}]}")
            .starts_with("scene.yaml:2:20: tissue.regions[0]: regions further down the list take every tetrahedron"));
}

TEST_CASE("fixed nodes are the same wherever the tissue stands") {
  const std::string fixed = "  fixed: [{box: {max: [.inf, .inf, -0.05]}}, {box: {min: [0.05, -.inf, -.inf]}}]\n";
  const Scene here = parse("tissue:\n" + fixed);
  const std::vector<bool> expected = find_fixed_nodes(here, load_mesh(here));
  CHECK(std::count(expected.begin(), expected.end(), true) == 190);
  const Scene there = parse("tissue:\n  pose: {position: [0.3, 7, -2], orientation: [0.1, 0.7, 0.1, 0.7]}\n" + fixed);
  CHECK(find_fixed_nodes(there, load_mesh(there)) == expected);
}

TEST_CASE("nodes on the boundary of any shape are fixed wherever the tissue stands") {
  const std::string fixed =
      "  mesh: {box: {size: [0.2, 0.2, 0.2], cells: [4, 4, 4]}}\n"
      "  fixed:\n    - half_space: {point: [0.1, 0.1, -0.1], normal: [0, 0, 1]}\n"
      "    - sphere: {center: [0, 0, 0.1], radius: 0.05}\n"
      "    - cylinder: {from: [-0.1, 0, 0.05], to: [0.1, 0, 0.05], radius: 0.05}\n";
  const Scene here = parse("tissue:\n" + fixed);
  const std::vector<bool> expected = find_fixed_nodes(here, load_mesh(here));
  // A face of 5 x 5 nodes; the rod with its axis and four lines at one edge's length; and of the sphere, a node with
  // its neighbours, the two that the rod leaves.
  CHECK(std::count(expected.begin(), expected.end(), true) == 25 + 5 * 5 + 2);
  const Scene there = parse("tissue:\n  pose: {position: [0.3, 7, -2], orientation: [0.1, 0.7, 0.1, 0.7]}\n" + fixed);
  CHECK(find_fixed_nodes(there, load_mesh(there)) == expected);
}

TEST_CASE("a fixed volume without nodes") {
  CHECK(
      error_of("tissue:\n  fixed:\n    - box: {max: [.inf, .inf, -0.06]}")
          .starts_with("scene.yaml:4:7: tissue.fixed[0]: expected a volume that holds nodes of the mesh, found none"));
}

TEST_CASE("a broken mesh leads to the field `mesh` and names the file") {
  SUBCASE("truncated") {
    const FileScene f(kTwoGroups.substr(0, kTwoGroups.find("2 4 2 9")), "");
    CHECK(error_of(f.scene).starts_with("scene.yaml:4:5: tissue.mesh: " + f.folder.path() + "/a.msh: line "));
  }
  SUBCASE("flat") {
    std::string flat = kTwoGroups;
    flat.replace(flat.find("5 1 1 1"), 7, "5 1 0 0");
    const FileScene f(flat, "");
    CHECK(error_of(f.scene).find("a.msh: tetrahedron 1 at (0.05, 0.025, 0.025) m is flat") != std::string::npos);
  }
  SUBCASE("beyond the workspace") {
    CHECK(error_of("tissue:\n  mesh: {box: {size: [20, 1, 1], cells: [1, 1, 1]}}\n  pose: {position: [-95, 0, 0]}") ==
          "scene.yaml:3:9: tissue.mesh: expected nodes in [-100, 100] m along each axis of the world, found one at "
          "[-105, -0.5, -0.5] m; mind the pose and metres_per_unit");
  }
}

TEST_CASE("the head mesh fills a scene of five regions") {
  const std::filesystem::path mesh = shared_data("meshes/head_plug_5regions.msh");
  if (mesh.empty()) return;
  const Scene scene = parse_scene(R"(acus_scene: 1
tissue:
  mesh: {gmsh: {file: head_plug_5regions.msh, metres_per_unit: 0.001}}
  regions:
    - name: brain
    - {name: scalp, physical_group: scalp}
    - {name: skull, physical_group: 3, interaction: {puncture_force: .inf}}
    - {name: csf, physical_group: csf}
)",
                                  "scene.yaml", mesh.parent_path().string());
  const std::vector<int> regions = assign_regions(scene, load_mesh(scene));
  CHECK(count_of(regions, 0) == 9866 + 6625);
  CHECK(count_of(regions, 1) == 2561);
  CHECK(count_of(regions, 2) == 2823);
  CHECK(count_of(regions, 3) == 5129);
}

}  // namespace acus
