// SPDX-License-Identifier: GPL-3.0-or-later
// Meshes: what the box generator and the Gmsh reader deliver, and every way in which a mesh can be broken.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "server/engine/scene/files/mesh_file.h"
#include "tests/support/shared_data.h"
#include "tests/support/temporary_folder.h"

namespace acus {
namespace {

// The unit tetrahedron, and a second one on its slanted face.
TetrahedralMesh two_tetrahedra() {
  TetrahedralMesh mesh;
  mesh.nodes.resize(3, 5);
  mesh.nodes.transpose() << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 1;
  mesh.tetrahedra = {{0, 1, 2, 3}, {4, 2, 1, 3}};
  return mesh;
}

template <class Action>
std::string error_of(Action action) {
  try {
    action();
  } catch (const MeshError& error) {
    return error.what();
  }
  return "no error";
}

std::string topology_error(TetrahedralMesh mesh) {
  return error_of([&mesh] { build_topology(mesh); });
}

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

double volume(const TetrahedralMesh& mesh) {
  double sum = 0;
  for (int t = 0; t < mesh.tetrahedron_count(); ++t) sum += rest_volume(mesh, t);
  return sum;
}

// By the divergence theorem a closed surface that faces outward encloses a third of the flux of x.
double enclosed_volume(const TetrahedralMesh& mesh) {
  double sum = 0;
  for (const std::array<int, 3>& face : mesh.surface) {
    sum += mesh.nodes.col(face[0]).dot(mesh.nodes.col(face[1]).cross(mesh.nodes.col(face[2]))) / 6;
  }
  return sum;
}

void check_neighbours(const TetrahedralMesh& mesh) {
  for (int t = 0; t < mesh.tetrahedron_count(); ++t) {
    for (int k = 0; k < 4; ++k) {
      const int other = mesh.neighbours[t][k];
      if (other < 0) continue;
      REQUIRE(std::count(mesh.neighbours[other].begin(), mesh.neighbours[other].end(), t) == 1);
      for (int node = 0; node < 4; ++node) {
        const std::array<int, 4>& corners = mesh.tetrahedra[other];
        const bool shared = std::count(corners.begin(), corners.end(), mesh.tetrahedra[t][node]) == 1;
        REQUIRE(shared == (node != k));
      }
    }
  }
}

// The mesh as Gmsh writes it, version 2.2: two tetrahedra in two volumes, a triangle, and a node that only it uses.
const std::string kTwoGroups = R"($MeshFormat
2.2 0 8
$EndMeshFormat
$PhysicalNames
1
3 7 "liver"
$EndPhysicalNames
$Nodes
6
10 0 0 0
20 1 0 0
30 0 1 0
40 0 0 1
50 1 1 1
60 9 9 9
$EndNodes
$Elements
3
1 2 2 1 1 10 20 60
2 4 2 7 1 10 20 30 40
3 4 2 9 2 50 20 30 40
$EndElements
)";

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  REQUIRE(at != std::string::npos);
  return text.replace(at, from.size(), to);
}

std::string file_error(const std::string& name, const std::string& text) {
  const TemporaryFolder folder;
  const std::string path = folder.write(name, text);
  const std::string error = error_of([&path] { read_mesh_file(path, 1); });
  CHECK(error.starts_with(path + ": "));
  return error;
}

}  // namespace

TEST_CASE("two tetrahedra: neighbours, surface and volume") {
  TetrahedralMesh mesh = two_tetrahedra();
  build_topology(mesh);
  CHECK(rest_volume(mesh, 0) == doctest::Approx(1.0 / 6));
  CHECK(rest_volume(mesh, 1) == doctest::Approx(1.0 / 3));
  CHECK(mesh.neighbours[0] == std::array<int, 4>{1, -1, -1, -1});
  CHECK(mesh.neighbours[1] == std::array<int, 4>{0, -1, -1, -1});
  CHECK(mesh.surface.size() == 6);
  CHECK(mesh.surface_tetrahedron == std::vector<int>{0, 0, 0, 1, 1, 1});
  CHECK(enclosed_volume(mesh) == doctest::Approx(volume(mesh)));
}

TEST_CASE("topology names what is wrong with a mesh") {
  SUBCASE("empty") { CHECK(contains(topology_error({}), "no tetrahedra")); }
  SUBCASE("index out of range") {
    TetrahedralMesh mesh = two_tetrahedra();
    mesh.tetrahedra[1][0] = 5;
    CHECK(topology_error(mesh) == "tetrahedron 1 names node 5, expected 0 to 4");
  }
  SUBCASE("not finite") {
    TetrahedralMesh mesh = two_tetrahedra();
    mesh.nodes(1, 2) = std::numeric_limits<double>::quiet_NaN();
    CHECK(topology_error(mesh) == "node 2 has a coordinate that is not finite");
  }
  SUBCASE("inverted") {
    TetrahedralMesh mesh = two_tetrahedra();
    std::swap(mesh.tetrahedra[1][0], mesh.tetrahedra[1][1]);
    CHECK(topology_error(mesh).starts_with("tetrahedron 1 at (0.5, 0.5, 0.5) m is inverted"));
  }
  SUBCASE("flat") {
    TetrahedralMesh mesh = two_tetrahedra();
    mesh.nodes.col(4) << 0.5, 0.5, 0;
    CHECK(contains(topology_error(mesh), "tetrahedron 1 at (0.375, 0.375, 0.25) m is flat"));
  }
  SUBCASE("a node twice in a tetrahedron") {
    TetrahedralMesh mesh = two_tetrahedra();
    mesh.tetrahedra.push_back({4, 4, 1, 3});
    CHECK(contains(topology_error(mesh), "tetrahedron 2"));
  }
  SUBCASE("unused node") {
    TetrahedralMesh mesh = two_tetrahedra();
    mesh.tetrahedra.pop_back();
    CHECK(topology_error(mesh) == "node 4 belongs to no tetrahedron");
  }
  SUBCASE("duplicate") {
    TetrahedralMesh mesh = two_tetrahedra();
    mesh.tetrahedra.push_back(mesh.tetrahedra[1]);
    CHECK(contains(topology_error(mesh), "shared by more than two tetrahedra"));
  }
  SUBCASE("overlap") {
    TetrahedralMesh mesh = two_tetrahedra();
    mesh.nodes.col(4) << 0.1, 0.1, 0.1;
    mesh.tetrahedra[1] = {4, 1, 2, 3};
    CHECK(contains(topology_error(mesh), "lie on the same side of their common face"));
  }
  SUBCASE("two parts that touch in a node") {
    TetrahedralMesh mesh = two_tetrahedra();
    mesh.nodes.resize(3, 7);
    mesh.nodes.transpose() << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, -1, 0, 0, 0, -1, 0, 0, 0, -1;
    mesh.tetrahedra[1] = {0, 5, 4, 6};
    CHECK(contains(topology_error(mesh), "(1 of 2 tetrahedra are)"));
  }
}

TEST_CASE("the box is centred, fills its volume and conforms") {
  const Vector3 size(0.1, 0.2, 0.3);
  const TetrahedralMesh mesh = make_box_mesh(size, {2, 3, 4});
  CHECK(mesh.node_count() == 3 * 4 * 5);
  CHECK(mesh.tetrahedron_count() == 6 * 2 * 3 * 4);
  CHECK(mesh.nodes.rowwise().minCoeff() == -size / 2);
  CHECK(mesh.nodes.rowwise().maxCoeff() == size / 2);
  CHECK(mesh.surface.size() == 2 * 2 * (2 * 3 + 3 * 4 + 4 * 2));
  CHECK(volume(mesh) == doctest::Approx(size.prod()));
  CHECK(enclosed_volume(mesh) == doctest::Approx(size.prod()));
  check_neighbours(mesh);
}

TEST_CASE("a box that cannot be is refused") {
  CHECK(contains(error_of([] { make_box_mesh({0.1, 0, 0.1}, {1, 1, 1}); }), "sizes > 0"));
  CHECK(contains(error_of([] { make_box_mesh({0.1, NAN, 0.1}, {1, 1, 1}); }), "sizes > 0"));
  CHECK(contains(error_of([] { make_box_mesh({0.1, 0.1, 0.1}, {1, 0, 1}); }), "at least one cell"));
  CHECK(contains(error_of([] { make_box_mesh({0.1, 0.1, 0.1}, {1000, 1000, 1000}); }), "at most"));
}

TEST_CASE("a large mesh has every tetrahedron connected") {
  const TetrahedralMesh mesh = make_box_mesh({0.1, 0.1, 0.1}, {22, 22, 21});
  CHECK(mesh.tetrahedron_count() > 60'000);
  CHECK(mesh.surface.size() == 2 * 2 * (22 * 22 + 2 * 22 * 21));
}

TEST_CASE("a mesh file: scale, groups, handedness, nodes that nothing uses") {
  const TemporaryFolder folder;
  const TetrahedralMesh mesh = read_mesh_file(folder.write("two.msh", kTwoGroups), 0.001);
  REQUIRE(mesh.node_count() == 5);
  REQUIRE(mesh.tetrahedron_count() == 2);
  CHECK(mesh.nodes.col(4) == Vector3(0.001, 0.001, 0.001));
  CHECK(mesh.groups == std::vector<MeshGroup>{{"", 7, "liver", {0}}, {"", 9, "", {1}}});
  // The second one stands in the file with negative volume.
  CHECK(rest_volume(mesh, 1) == doctest::Approx(1e-9 / 3));
  CHECK(mesh.neighbours[0][0] == 1);
}

TEST_CASE("reading a mesh file twice gives the same mesh") {
  const TemporaryFolder folder;
  const std::string path = folder.write("two.msh", kTwoGroups);
  const TetrahedralMesh first = read_mesh_file(path, 1);
  const TetrahedralMesh second = read_mesh_file(path, 1);
  CHECK(first.nodes == second.nodes);
  CHECK(first.tetrahedra == second.tetrahedra);
}

TEST_CASE("a mesh file that cannot be used is named, with the reason" * doctest::test_suite("gate")) {
  SUBCASE("missing") {
    CHECK(error_of([] { read_mesh_file("no/such.msh", 1); }) ==
          "no/such.msh: expected a mesh file, found: No such file or directory");
  }
  SUBCASE("unit") {
    const TemporaryFolder folder;
    const std::string path = folder.write("two.msh", kTwoGroups);
    CHECK(contains(error_of([&path] { read_mesh_file(path, 0); }), "metres_per_unit > 0"));
  }
  SUBCASE("empty") { CHECK(contains(file_error("a.msh", ""), "found an empty file")); }
  SUBCASE("truncated anywhere") {
    for (const char* stop : {"30 0 1", "$EndNodes", "3 4 2 9 2", "50 20 30 40"}) {
      CAPTURE(stop);
      const std::string error = file_error("a.msh", kTwoGroups.substr(0, kTwoGroups.find(stop)));
      CHECK_FALSE(contains(error, "no error"));
    }
  }
  SUBCASE("only a surface") {
    const std::string surface = replaced(
        kTwoGroups, "3\n1 2 2 1 1 10 20 60\n2 4 2 7 1 10 20 30 40\n3 4 2 9 2 50 20 30 40", "1\n1 2 2 1 1 10 20 60");
    CHECK(contains(file_error("a.msh", surface), "found 1 triangles; fill the surface with tetrahedra"));
  }
  SUBCASE("flat") {
    const std::string flat = replaced(kTwoGroups, "50 1 1 1", "50 0.5 0.5 0");
    CHECK(contains(file_error("a.msh", flat), "is flat"));
  }
  SUBCASE("two parts") {
    const std::string apart = replaced(replaced(kTwoGroups, "$Nodes\n6\n", "$Nodes\n7\n70 8 9 7\n"),
                                       "3 4 2 9 2 50 20 30 40", "3 4 2 9 2 50 20 60 70");
    const std::string error = file_error("a.msh", apart);
    CAPTURE(error);
    CHECK(contains(error, "not connected"));
  }
  SUBCASE("not finite") {
    for (const char* number : {"nan", "inf", "1e999"}) {
      CAPTURE(number);
      const std::string broken = replaced(kTwoGroups, "50 1 1 1", std::string("50 1 1 ") + number);
      CHECK_FALSE(contains(file_error("a.msh", broken), "no error"));
    }
  }
  SUBCASE("an element that names a node which is not there") {
    const std::string broken = replaced(kTwoGroups, "50 20 30 40", "51 20 30 40");
    CHECK_FALSE(contains(file_error("a.msh", broken), "no error"));
  }
}

TEST_CASE("the liver mesh is read (Gmsh 1)") {
  const std::string path = shared_data("meshes/sofa_liver.msh");
  if (path.empty()) return;
  const TetrahedralMesh mesh = read_mesh_file(path, 0.034);
  CHECK(mesh.node_count() == 181);
  CHECK(mesh.tetrahedron_count() == 596);
  CHECK(enclosed_volume(mesh) == doctest::Approx(volume(mesh)));
  check_neighbours(mesh);
}

TEST_CASE("the head mesh is read with its five regions (Gmsh 2.2)") {
  const std::string path = shared_data("meshes/head_plug_5regions.msh");
  if (path.empty()) return;
  const TetrahedralMesh mesh = read_mesh_file(path, 0.001);
  CHECK(mesh.node_count() == 5275);
  CHECK(mesh.tetrahedron_count() == 27004);
  std::vector<std::string> labels;
  for (const MeshGroup& group : mesh.groups) labels.push_back(group.label());
  CHECK(labels == std::vector<std::string>{"2 (scalp)", "3 (skull)", "4 (csf)", "5 (gray_matter)", "6 (white_matter)"});
  CHECK(mesh.groups[1].members.size() == 2823);
  CHECK(enclosed_volume(mesh) == doctest::Approx(volume(mesh)));
}

}  // namespace acus
