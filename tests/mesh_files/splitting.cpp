// SPDX-License-Identifier: GPL-3.0-or-later
// Elements become tetrahedra that fill the same space and match those of their neighbours.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <random>

#include "tests/mesh_files/read_text.h"

namespace acus {
namespace {

using test::error_of;
using test::read_text;
using test::surface_area;
using test::volume;
using test::with_topology;

// A file of Gmsh 2.2 from elements that name places.
class Maker {
 public:
  explicit Maker(unsigned seed) : random_(seed) {}

  void add(int type, const std::vector<Vector3>& places) {
    std::vector<int> nodes;
    for (const Vector3& place : places) nodes.push_back(node_at(place));
    elements_.emplace_back(type, nodes);
  }

  // Nodes are numbered in random order.
  std::string text() {
    std::vector<int> numbers(places_.size());
    for (std::size_t i = 0; i < numbers.size(); ++i) numbers[i] = static_cast<int>(i) + 1;
    std::shuffle(numbers.begin(), numbers.end(), random_);
    std::string text = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n" + std::to_string(places_.size()) + "\n";
    for (std::size_t i = 0; i < places_.size(); ++i) {
      text += std::to_string(numbers[i]);
      for (const double x : places_[i]) text += " " + std::to_string(x);
      text += "\n";
    }
    text += "$EndNodes\n$Elements\n" + std::to_string(elements_.size()) + "\n";
    for (std::size_t e = 0; e < elements_.size(); ++e) {
      text += std::to_string(e + 1) + " " + std::to_string(elements_[e].first) + " 2 1 1";
      for (const int node : elements_[e].second) text += " " + std::to_string(numbers[static_cast<std::size_t>(node)]);
      text += "\n";
    }
    return text + "$EndElements\n";
  }

 private:
  int node_at(const Vector3& place) {
    const auto same = [&place](const Vector3& other) { return (other - place).norm() < 1e-9; };
    const auto found = std::find_if(places_.begin(), places_.end(), same);
    if (found != places_.end()) return static_cast<int>(found - places_.begin());
    places_.push_back(place);
    return static_cast<int>(places_.size()) - 1;
  }

  std::mt19937 random_;
  std::vector<Vector3> places_;
  std::vector<std::pair<int, std::vector<int>>> elements_;
};

constexpr int kTetrahedron = 4, kHexahedron = 5, kPrism = 6, kPyramid = 7, kTetrahedron10 = 11;

using Cube = std::array<Vector3, 8>;

Cube cube_at(const Vector3& o) {
  const auto at = [&o](double x, double y, double z) { return Vector3(o + Vector3(x, y, z)); };
  return {at(0, 0, 0), at(1, 0, 0), at(1, 1, 0), at(0, 1, 0), at(0, 0, 1), at(1, 0, 1), at(1, 1, 1), at(0, 1, 1)};
}

// One cube as a hexahedron, or as six pyramids.
void add_cube(Maker& maker, const Cube& c, bool of_pyramids) {
  const Vector3 middle = (c[0] + c[6]) / 2;
  if (!of_pyramids) return maker.add(kHexahedron, {c.begin(), c.end()});
  for (const std::array<int, 4>& f :
       {std::array{0, 1, 2, 3}, {4, 7, 6, 5}, {0, 4, 5, 1}, {1, 5, 6, 2}, {2, 6, 7, 3}, {3, 7, 4, 0}})
    maker.add(kPyramid, {c[f[0]], c[f[1]], c[f[2]], c[f[3]], middle});
}

// The edges' middles of a tetrahedron, in Gmsh's order.
std::vector<Vector3> quadratic(const std::array<Vector3, 4>& c) {
  const auto middle = [&c](int a, int b) { return Vector3((c[a] + c[b]) / 2); };
  return {c[0], c[1], c[2], c[3], middle(0, 1), middle(1, 2), middle(0, 2), middle(0, 3), middle(2, 3), middle(1, 3)};
}

}  // namespace

TEST_CASE("hexahedra and pyramids side by side become one conforming mesh, however nodes are numbered") {
  for (unsigned seed = 0; seed < 20; ++seed) {
    CAPTURE(seed);
    Maker maker(seed);
    std::mt19937 random(seed + 100);
    for (int x = 0; x < 3; ++x)
      for (int y = 0; y < 3; ++y)
        for (int z = 0; z < 3; ++z) add_cube(maker, cube_at(Vector3(x, y, z)), random() % 2 == 0);
    const TetrahedralMesh mesh = with_topology(read_text(maker.text()));
    CHECK(volume(mesh) == doctest::Approx(27));
    CHECK(surface_area(mesh) == doctest::Approx(54));
  }
}

TEST_CASE("prisms in columns become one conforming mesh, beside a hexahedron and a tetrahedron") {
  for (unsigned seed = 0; seed < 20; ++seed) {
    CAPTURE(seed);
    Maker maker(seed);
    for (int z = 0; z < 3; ++z) {
      const Cube c = cube_at(Vector3(0, 0, z));
      maker.add(kPrism, {c[0], c[1], c[2], c[4], c[5], c[6]});
      maker.add(kPrism, {c[0], c[2], c[3], c[4], c[6], c[7]});
      const Cube beside = cube_at(Vector3(1, 0, z));
      maker.add(kHexahedron, {beside.begin(), beside.end()});
    }
    const Cube top = cube_at(Vector3(0, 0, 3));
    maker.add(kTetrahedron, {top[0], top[1], top[2], top[4]});
    const RawMesh raw = read_text(maker.text());
    CHECK(raw.notes == std::vector<std::string>{"6 prisms, 3 hexahedra split into 36 tetrahedra"});
    const TetrahedralMesh mesh = with_topology(raw);
    CHECK(volume(mesh) == doctest::Approx(6 + 1.0 / 6));
    // The tetrahedron covers half of a square of the top.
    CHECK(surface_area(mesh) == doctest::Approx(22 + std::sqrt(2.0)));
  }
}

TEST_CASE("quadratic tetrahedra become eight each, and keep their curved surface") {
  const std::array<Vector3, 4> a{Vector3(0, 0, 0), Vector3(1, 0, 0), Vector3(0, 1, 0), Vector3(0, 0, 1)};
  const std::array<Vector3, 4> b{Vector3(1, 0, 0), Vector3(0, 1, 0), Vector3(0, 0, 1), Vector3(1, 1, 1)};
  Maker maker(1);
  maker.add(kTetrahedron10, quadratic(a));
  maker.add(kTetrahedron10, quadratic(b));
  const RawMesh raw = read_text(maker.text());
  CHECK(raw.notes == std::vector<std::string>{"2 quadratic tetrahedra split into 16 tetrahedra"});
  const TetrahedralMesh mesh = with_topology(raw);
  CHECK(mesh.tetrahedron_count() == 16);
  CHECK(volume(mesh) == doctest::Approx(1.0 / 6 + 1.0 / 3));
  CHECK(raw.groups[0].members.size() == 16);

  std::vector<Vector3> bulged = quadratic(a);
  bulged[4] += Vector3(0, -0.1, 0);
  Maker curved(2);
  curved.add(kTetrahedron10, bulged);
  const TetrahedralMesh bulge = with_topology(read_text(curved.text()));
  // Tetrahedra of the edge's middle, with the halves of the face z = 0, now 0.1 wider.
  CHECK(volume(bulge) > 1.0 / 6 + 0.005);
}

TEST_CASE("nodes between corners are left out where they would invert a tetrahedron, or where others have none") {
  const std::array<Vector3, 4> a{Vector3(0, 0, 0), Vector3(1, 0, 0), Vector3(0, 1, 0), Vector3(0, 0, 1)};
  std::vector<Vector3> inverted = quadratic(a);
  inverted[4] = Vector3(0.3, 0.6, 0.3);
  Maker maker(1);
  maker.add(kTetrahedron10, inverted);
  const RawMesh raw = read_text(maker.text());
  CHECK(raw.notes == std::vector<std::string>{"nodes between corners of 1 elements left out"});
  CHECK(raw.tetrahedra.size() == 4);

  Maker mixed(1);
  mixed.add(kTetrahedron10, quadratic(a));
  mixed.add(kTetrahedron, {Vector3(1, 0, 0), Vector3(0, 1, 0), Vector3(0, 0, 1), Vector3(1, 1, 1)});
  CHECK(with_topology(read_text(mixed.text())).tetrahedron_count() == 2);
}

TEST_CASE("a hexahedron with corners twice is the prism or pyramid that it stands for") {
  const Cube c = cube_at(Vector3::Zero());
  Maker prism(1);
  prism.add(kHexahedron, {c[0], c[1], c[2], c[2], c[4], c[5], c[6], c[6]});
  CHECK(volume(with_topology(read_text(prism.text()))) == doctest::Approx(0.5));
  Maker pyramid(1);
  pyramid.add(kHexahedron, {c[0], c[1], c[2], c[3], c[4], c[4], c[4], c[4]});
  CHECK(volume(with_topology(read_text(pyramid.text()))) == doctest::Approx(1.0 / 3));
}

TEST_CASE("a twisted hexahedron is split from its middle, and still matches its neighbours") {
  Cube twisted = cube_at(Vector3(0, 0, 1));
  twisted[4] = Vector3(0.6, 0, 2);
  twisted[5] = Vector3(1, 0.6, 2);
  twisted[6] = Vector3(0.4, 1, 2);
  twisted[7] = Vector3(0, 0.4, 2);
  const Cube below = cube_at(Vector3::Zero());
  std::size_t with_middle = 0;
  for (unsigned seed = 0; seed < 20; ++seed) {
    CAPTURE(seed);
    Maker maker(seed);
    maker.add(kHexahedron, {below.begin(), below.end()});
    maker.add(kHexahedron, {twisted.begin(), twisted.end()});
    const RawMesh raw = read_text(maker.text());
    with_middle += raw.notes.size() - 1;
    const TetrahedralMesh mesh = with_topology(raw);
    CHECK(mesh.tetrahedron_count() == (raw.notes.size() > 1 ? 18 : 12));
    CHECK(volume(mesh) > 1.5);  // 1.54 to 1.68, as the sides are bent one way or the other
  }
  CHECK(with_middle > 0);
}

TEST_CASE("an element that is inside out in part is refused with its line") {
  Cube c = cube_at(Vector3::Zero());
  c[6] = Vector3(-0.5, -0.5, -0.5);
  Maker maker(1);
  maker.add(kHexahedron, {c.begin(), c.end()});
  CHECK(error_of(maker.text()) ==
        "line 17: the hexahedron is turned inside out in part, so it cannot be split into tetrahedra; mend it, or mesh "
        "with tetrahedra");
}

}  // namespace acus
