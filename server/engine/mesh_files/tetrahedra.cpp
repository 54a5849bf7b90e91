// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/mesh_files/tetrahedra.h"

#include <algorithm>
#include <optional>
#include <tuple>

#include "server/engine/models/geometry/tetrahedral_mesh.h"

namespace acus {
namespace {

using Corners = std::array<int, 4>;

const char* name_of(Shape shape) {
  constexpr std::array names{"tetrahedron", "pyramid", "prism", "hexahedron"};
  return names[static_cast<std::size_t>(shape)];
}

// "3 hexahedra"
std::string counted(std::size_t count, Shape shape) {
  constexpr std::array many{"tetrahedra", "pyramids", "prisms", "hexahedra"};
  return std::to_string(count) + " " + (count == 1 ? name_of(shape) : many[static_cast<std::size_t>(shape)]);
}

// ---- Numbers of the file

// Ascending by number; a node that is listed twice at the same place stays once.
void sort_nodes(const FileText& file, std::vector<MeshNode>& nodes) {
  const auto before = [](const MeshNode& a, const MeshNode& b) { return a.number < b.number; };
  if (!std::is_sorted(nodes.begin(), nodes.end(), before)) std::stable_sort(nodes.begin(), nodes.end(), before);
  for (std::size_t i = 1; i < nodes.size(); ++i) {
    if (nodes[i].number != nodes[i - 1].number || nodes[i].x == nodes[i - 1].x) continue;
    file.fail_at(nodes[i].at, "node " + std::to_string(nodes[i].number) + " stands twice, first in " +
                                  file.place(nodes[i - 1].at) + ", at another place; number nodes once each");
  }
  const auto same = [](const MeshNode& a, const MeshNode& b) { return a.number == b.number; };
  nodes.erase(std::unique(nodes.begin(), nodes.end(), same), nodes.end());
}

void check_element_numbers(const FileText& file, const std::vector<MeshElement>& elements) {
  std::vector<std::pair<std::int64_t, std::size_t>> numbers;
  for (const MeshElement& element : elements)
    if (element.number != 0) numbers.emplace_back(element.number, element.at);
  std::sort(numbers.begin(), numbers.end());
  for (std::size_t i = 1; i < numbers.size(); ++i) {
    if (numbers[i].first != numbers[i - 1].first) continue;
    file.fail_at(numbers[i].second, "element number " + std::to_string(numbers[i].first) + " stands twice, first in " +
                                        file.place(numbers[i - 1].second) + "; number elements once each");
  }
}

// Positions of nodes in the ascending list in place of their numbers.
void resolve_nodes(const FileText& file, const std::vector<MeshNode>& nodes, std::vector<MeshElement>& elements) {
  const auto before = [](const MeshNode& node, std::int64_t number) { return node.number < number; };
  for (MeshElement& element : elements) {
    for (std::int64_t& number : element.used_nodes()) {
      const auto found = std::lower_bound(nodes.begin(), nodes.end(), number, before);
      if (found == nodes.end() || found->number != number)
        file.fail_at(element.at, "the element names node " + std::to_string(number) + ", which is not in the file");
      number = found - nodes.begin();
    }
  }
}

// ---- Shapes

// Faces as corners along their outline; -1: a triangle.
using Face = std::array<int, 4>;
std::span<const Face> faces_of(Shape shape) {
  static constexpr std::array<Face, 5> kPyramid{
      {{0, 3, 2, 1}, {0, 1, 4, -1}, {1, 2, 4, -1}, {2, 3, 4, -1}, {3, 0, 4, -1}}};
  static constexpr std::array<Face, 5> kPrism{{{0, 2, 1, -1}, {3, 4, 5, -1}, {0, 1, 4, 3}, {1, 2, 5, 4}, {2, 0, 3, 5}}};
  static constexpr std::array<Face, 6> kHexahedron{
      {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}}};
  if (shape == Shape::pyramid) return kPyramid;
  return shape == Shape::prism ? std::span<const Face>(kPrism) : kHexahedron;
}

// Splits one element after another, and keeps the element of each tetrahedron.
class Splitter {
 public:
  Splitter(const FileText& file, MeshContents& contents, bool use_middles)
      : file_(file), contents_(contents), use_middles_(use_middles) {}

  // False where a tetrahedron between middles would be inverted.
  bool split_all() {
    for (std::size_t e = 0; e < contents_.elements.size(); ++e) {
      first_ = tetrahedra.size();
      split(contents_.elements[e]);
      if (!oriented_alike()) {
        if (use_middles_) return false;
        split_from_middle(contents_.elements[e]);
        if (!oriented_alike()) refuse_inverted(contents_.elements[e]);
      }
      element_of.resize(tetrahedra.size(), static_cast<int>(e));
    }
    return true;
  }

  std::vector<Corners> tetrahedra;  // positions of nodes
  std::vector<int> element_of;      // of each tetrahedron
  std::size_t added_nodes = 0;

 private:
  void split(const MeshElement& element) {
    if (element.shape != Shape::tetrahedron)
      split_from_smallest(element);
    else if (use_middles_)
      split_at_middles(element);
    else
      add(node(element, 0), node(element, 1), node(element, 2), node(element, 3));
  }

  static int node(const MeshElement& element, int i) { return static_cast<int>(element.nodes[i]); }

  void split_from_smallest(const MeshElement& element) {
    const std::size_t corners = corner_count(element.shape);
    join_to_faces(element, static_cast<int>(*std::min_element(element.nodes.begin(), element.nodes.begin() + corners)));
  }

  // In place of the tetrahedra that it has: all faces are joined to a new node, and split as they were.
  void split_from_middle(const MeshElement& element) {
    tetrahedra.resize(first_);
    Vector3 middle = Vector3::Zero();
    const std::size_t corners = corner_count(element.shape);
    for (std::size_t i = 0; i < corners; ++i)
      middle += place(node(element, static_cast<int>(i))) / static_cast<double>(corners);
    contents_.nodes.push_back({contents_.nodes.back().number + 1, kNoPlace, {middle.x(), middle.y(), middle.z()}});
    ++added_nodes;
    join_to_faces(element, static_cast<int>(contents_.nodes.size()) - 1);
  }

  void join_to_faces(const MeshElement& element, int apex) {
    for (const Face& face : faces_of(element.shape)) {
      std::vector<int> outline;
      for (const int corner : face)
        if (corner >= 0) outline.push_back(node(element, corner));
      if (std::find(outline.begin(), outline.end(), apex) != outline.end()) continue;
      std::rotate(outline.begin(), std::min_element(outline.begin(), outline.end()), outline.end());
      for (std::size_t i = 2; i < outline.size(); ++i)
        add_unless_collapsed({outline[i - 1], outline[0], outline[i], apex});
    }
  }

  void split_at_middles(const MeshElement& e) {
    const auto n = [&e](int i) { return node(e, i); };
    add(n(0), n(4), n(6), n(7));
    add(n(4), n(1), n(5), n(8));
    add(n(6), n(5), n(2), n(9));
    add(n(7), n(8), n(9), n(3));
    // The octahedron between the middles, around the shortest of its three diagonals: from `a` to `b`, with the other
    // middles in a ring about it.
    struct Diagonal {
      int a, b;
      std::array<int, 4> ring;
    };
    constexpr std::array<Diagonal, 3> kDiagonals{{{4, 9, {5, 8, 7, 6}}, {5, 7, {4, 6, 9, 8}}, {6, 8, {4, 7, 9, 5}}}};
    const auto shorter = [&](const Diagonal& one, const Diagonal& other) {
      return square(n(one.a), n(one.b)) < square(n(other.a), n(other.b));
    };
    const Diagonal& way = *std::min_element(kDiagonals.begin(), kDiagonals.end(), shorter);
    for (int i = 0; i < 4; ++i) add(n(way.b), n(way.a), n(way.ring[i]), n(way.ring[(i + 1) % 4]));
  }

  void add(int a, int b, int c, int d) { tetrahedra.push_back({a, b, c, d}); }
  // Of an element with a corner twice, as prisms are written as hexahedra.
  void add_unless_collapsed(Corners corners) {
    Corners sorted = corners;
    std::sort(sorted.begin(), sorted.end());
    if (std::adjacent_find(sorted.begin(), sorted.end()) == sorted.end()) tetrahedra.push_back(corners);
  }

  Vector3 place(int node) const { return Vector3(contents_.nodes[static_cast<std::size_t>(node)].x.data()); }
  double square(int a, int b) const { return (place(a) - place(b)).squaredNorm(); }
  double six_volumes(const Corners& t) const {
    const Vector3 origin = place(t[0]);
    return (place(t[1]) - origin).cross(place(t[2]) - origin).dot(place(t[3]) - origin);
  }

  // Whether no two of the element's tetrahedra have volumes of different signs.
  bool oriented_alike() const {
    double least = 0, most = 0;
    for (std::size_t t = first_; t < tetrahedra.size(); ++t) {
      const double volume = six_volumes(tetrahedra[t]);
      least = std::min(least, volume);
      most = std::max(most, volume);
    }
    return least == 0 || most == 0;
  }

  [[noreturn]] void refuse_inverted(const MeshElement& element) const {
    const std::string where =
        element.at == kNoPlace ? "volume cell " + std::to_string(element.number) : file_.place(element.at);
    throw MeshError(where + ": the " + name_of(element.shape) +
                    " is turned inside out in part, so it cannot be split into tetrahedra; mend it, or mesh with "
                    "tetrahedra");
  }

  const FileText& file_;
  MeshContents& contents_;  // its nodes grow by what is put into elements
  bool use_middles_;
  std::size_t first_ = 0;  // of the element's tetrahedra
};

// ---- What is told

void tell_split(const MeshContents& contents, const Splitter& done, bool use_middles, RawMesh& mesh) {
  std::map<Shape, std::size_t> of_shape;
  std::size_t quadratic = 0;
  for (const MeshElement& element : contents.elements) {
    ++of_shape[element.shape];
    quadratic += element.quadratic;
  }
  std::string split;
  for (const auto& [shape, count] : of_shape)
    if (shape != Shape::tetrahedron) split += (split.empty() ? "" : ", ") + counted(count, shape);
  const std::size_t whole = of_shape[Shape::tetrahedron];
  if (use_middles) split = std::to_string(whole) + " quadratic tetrahedra";
  const std::size_t parts = done.tetrahedra.size() - (use_middles ? 0 : whole);
  if (!split.empty()) mesh.notes.push_back(split + " split into " + counted(parts, Shape::tetrahedron));
  if (done.added_nodes > 0)
    mesh.notes.push_back("a node put into the middle of " + std::to_string(done.added_nodes) + " of them");
  if (quadratic > 0 && !use_middles)
    mesh.notes.push_back("nodes between corners of " + std::to_string(quadratic) + " elements left out");
}

// "3 lines, 2 triangles"
std::string list_left_out(const MeshContents& contents) {
  std::string text;
  for (const auto& [kind, count] : contents.left_out)
    text += (text.empty() ? "" : ", ") + std::to_string(count) + " " + kind;
  return text;
}

void tell_left_out(const MeshContents& contents, RawMesh& mesh) {
  const std::string text = list_left_out(contents);
  if (!text.empty()) mesh.notes.push_back("not needed: " + text);
  mesh.notes.insert(mesh.notes.end(), contents.remarks.begin(), contents.remarks.end());
}

// ---- The result

// Nodes that tetrahedra use, in their order; surfaces and construction points leave others.
void keep_used_nodes(const std::vector<MeshNode>& nodes, const std::vector<Corners>& tetrahedra, RawMesh& mesh) {
  std::vector<std::int32_t> position(nodes.size(), -1);
  for (const Corners& corners : tetrahedra)
    for (const int node : corners) position[static_cast<std::size_t>(node)] = 0;
  std::int32_t used = 0;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (position[i] < 0) continue;
    position[i] = used++;
    mesh.coordinates.insert(mesh.coordinates.end(), nodes[i].x.begin(), nodes[i].x.end());
  }
  for (const Corners& corners : tetrahedra)
    for (const int node : corners) mesh.tetrahedra.push_back(position[static_cast<std::size_t>(node)]);
}

// `element` is ascending: the tetrahedra of an element follow each other.
void convert_groups(std::vector<MeshGroup> groups, const std::vector<int>& element, RawMesh& mesh) {
  for (MeshGroup& group : groups) {
    std::sort(group.members.begin(), group.members.end());
    group.members.erase(std::unique(group.members.begin(), group.members.end()), group.members.end());
    std::vector<int> tetrahedra;
    for (const int e : group.members) {
      const auto [first, last] = std::equal_range(element.begin(), element.end(), e);
      for (auto t = first; t != last; ++t) tetrahedra.push_back(static_cast<int>(t - element.begin()));
    }
    group.members = std::move(tetrahedra);
    if (!group.members.empty()) mesh.groups.push_back(std::move(group));
  }
  const auto before = [](const MeshGroup& a, const MeshGroup& b) {
    return std::tie(a.array, a.number, a.name) < std::tie(b.array, b.number, b.name);
  };
  std::stable_sort(mesh.groups.begin(), mesh.groups.end(), before);
}

[[noreturn]] void refuse_without_volume(const MeshContents& contents) {
  const std::string found = list_left_out(contents);
  throw MeshError("expected tetrahedra, hexahedra, prisms or pyramids, found " + (found.empty() ? "none" : found) +
                  "; fill the surface with tetrahedra, for instance with Gmsh (gmsh -3) or TetGen, and save those");
}

}  // namespace

RawMesh make_tetrahedra(const FileText& file, MeshContents contents) {
  if (contents.elements.empty()) refuse_without_volume(contents);
  sort_nodes(file, contents.nodes);
  check_element_numbers(file, contents.elements);
  resolve_nodes(file, contents.nodes, contents.elements);
  bool use_middles = std::all_of(contents.elements.begin(), contents.elements.end(),
                                 [](const MeshElement& element) { return element.has_middles; });
  std::optional<Splitter> splitter(std::in_place, file, contents, use_middles);
  if (!splitter->split_all()) {
    use_middles = false;
    splitter.emplace(file, contents, use_middles).split_all();
  }
  RawMesh mesh;
  mesh.format = contents.format;
  keep_used_nodes(contents.nodes, splitter->tetrahedra, mesh);
  tell_split(contents, *splitter, use_middles, mesh);
  tell_left_out(contents, mesh);
  convert_groups(std::move(contents.groups), splitter->element_of, mesh);
  return mesh;
}

}  // namespace acus
