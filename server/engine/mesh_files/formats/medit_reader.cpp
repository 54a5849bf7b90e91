// SPDX-License-Identifier: GPL-3.0-or-later
// Medit's format: https://www.ljll.fr/frey/publications/RT-0253.pdf, and its binary form, libMeshb
// (https://github.com/LoicMarechal/libMeshb, "GMF file format").
#include <cctype>
#include <cmath>

#include "server/engine/mesh_files/formats/readers.h"
#include "server/engine/models/geometry/tetrahedral_mesh.h"

namespace acus {
namespace {

// A section of entities with nodes and a reference.
struct MeditKind {
  std::string_view keyword;
  int code;  // in binary files
  std::size_t nodes;
  const char* flat;  // what is counted, or null for a volume
  ElementType volume;
};

constexpr std::array<MeditKind, 13> kKinds{{
    {"Edges", 5, 2, "lines", {}},
    {"Triangles", 6, 3, "triangles", {}},
    {"Quadrilaterals", 7, 4, "quadrangles", {}},
    {"Tetrahedra", 8, 4, nullptr, {Shape::tetrahedron, 4}},
    {"Prisms", 9, 6, nullptr, {Shape::prism, 6}},
    {"Pentahedra", 9, 6, nullptr, {Shape::prism, 6}},
    {"Pyramids", 49, 5, nullptr, {Shape::pyramid, 5}},
    {"Hexahedra", 10, 8, nullptr, {Shape::hexahedron, 8}},
    {"Hexaedra", 10, 8, nullptr, {Shape::hexahedron, 8}},
    {"TrianglesP2", 24, 6, "triangles", {}},
    {"EdgesP2", 25, 3, "lines", {}},
    // Its nodes between corners stand in no fixed order.
    {"TetrahedraP2", 30, 10, nullptr, {Shape::tetrahedron, 11}},
    {"HexahedraQ2", 33, 27, nullptr, {Shape::hexahedron, 27}},
}};

class MeditReader {
 public:
  explicit MeditReader(std::string_view bytes) : file_(bytes, '#'), groups_(contents_.groups) {}

  MeshContents read_text() {
    file_.expect("MeshVersionFormatted", "the first word of a Medit file");
    contents_.format = "Medit " + std::to_string(file_.integer("the version"));
    while (!file_.peek().empty()) {
      const std::string keyword(file_.word("a section"));
      if (keyword == "End") break;
      read_section(keyword);
    }
    return std::move(contents_);
  }

  MeshContents read_binary() {
    const int one = file_.binary<int>("the number one");
    file_.swap_bytes(one != 1);
    version_ = file_.binary<int>("the version");
    if (version_ < 1 || version_ > 4) file_.fail("expected version 1 to 4 of the binary format");
    contents_.format = "Medit " + std::to_string(version_) + ", binary";
    binary_ = true;
    constexpr int kEnd = 54;
    for (int code = file_.binary<int>("a section"); code != kEnd; code = file_.binary<int>("a section")) {
      const std::int64_t next = position();
      if (next != 0 && next <= static_cast<std::int64_t>(file_.at())) file_.fail("a section ends before it begins");
      read_binary_section(code, next);
      if (next == 0) break;
    }
    return std::move(contents_);
  }

 private:
  void read_section(const std::string& keyword) {
    if (keyword == "Dimension") return check_dimension(file_.integer("the dimension"));
    if (keyword == "Vertices") return read_nodes(file_.count("the number of vertices"), 0);
    for (const MeditKind& kind : kKinds)
      if (keyword == kind.keyword) return read_elements(kind, file_.count("the number of elements"), 0);
    if (std::isalpha(static_cast<unsigned char>(keyword.front())) == 0)
      file_.fail("expected a section, found " + in_quotes(keyword) +
                 "; the section before it announces fewer entries than it has");
    while (!file_.peek().empty() && std::isalpha(static_cast<unsigned char>(file_.peek().front())) == 0)
      file_.word("a number");
  }

  void read_binary_section(int code, std::int64_t next) {
    constexpr int kDimension = 3, kVertices = 4;
    if (code == kDimension) return check_dimension(file_.binary<int>("the dimension"));
    if (code == kVertices) return read_nodes(binary_count("the number of vertices"), next);
    for (const MeditKind& kind : kKinds)
      if (code == kind.code) return read_elements(kind, binary_count("the number of elements"), next);
    if (next != 0) file_.go_to(static_cast<std::size_t>(next));
  }

  void check_dimension(std::int64_t dimension) {
    if (dimension != 3)
      file_.fail("expected dimension 3, found " + std::to_string(dimension) + ": a mesh without volume");
  }

  std::int64_t position() {
    return version_ < 3 ? file_.binary<std::int32_t>("a place") : file_.binary<std::int64_t>("a place");
  }
  std::int64_t number(const char* what) {
    if (!binary_) return file_.integer(what);
    return version_ < 4 ? file_.binary<std::int32_t>(what) : file_.binary<std::int64_t>(what);
  }
  std::size_t binary_count(const char* what) {
    const std::int64_t count = number(what);
    if (count < 0) file_.fail(std::string("expected ") + what + ", found " + std::to_string(count));
    return static_cast<std::size_t>(count);
  }
  double coordinate() {
    if (!binary_) return file_.real("a coordinate");
    const double value = version_ == 1 ? file_.binary<float>("a coordinate") : file_.binary<double>("a coordinate");
    if (!std::isfinite(value)) file_.fail("expected a finite coordinate");
    return value;
  }

  void expect_next(std::int64_t next, const char* section) {
    if (next == 0 || next == static_cast<std::int64_t>(file_.at())) return;
    file_.fail(std::string("section ") + section + " has another size than the number of its entries says");
  }

  void read_nodes(std::size_t nodes, std::int64_t next) {
    for (std::size_t i = 0; i < nodes; ++i) {
      const double x = coordinate();
      const std::size_t at = file_.word_at();
      const double y = coordinate(), z = coordinate();
      number("a reference");
      contents_.nodes.push_back({static_cast<std::int64_t>(contents_.nodes.size()) + 1, at, {x, y, z}});
    }
    expect_next(next, "Vertices");
  }

  void read_elements(const MeditKind& kind, std::size_t elements, std::int64_t next) {
    std::vector<std::int64_t> nodes(kind.nodes + 1);
    for (std::size_t i = 0; i < elements; ++i) {
      nodes[0] = number("a node of an element");
      const std::size_t at = file_.word_at();
      for (std::size_t n = 1; n < kind.nodes; ++n) nodes[n] = number("a node of an element");
      const std::int64_t reference = number("a reference");
      add(kind, at, nodes, reference);
    }
    expect_next(next, std::string(kind.keyword).c_str());
  }

  void add(const MeditKind& kind, std::size_t at, std::span<const std::int64_t> nodes, std::int64_t reference) {
    if (kind.flat) {
      ++contents_.left_out[kind.flat];
      return;
    }
    for (const std::int64_t node : nodes.first(kind.nodes))
      if (node < 1) file_.fail_at(at, "the element names node " + std::to_string(node) + ": numbers begin at 1");
    groups_.of("", reference).members.push_back(static_cast<int>(contents_.elements.size()));
    contents_.add_element(kind.volume, 0, at, nodes);
  }

  FileText file_;
  MeshContents contents_;
  GroupMaker groups_;
  int version_ = 0;
  bool binary_ = false;
};

}  // namespace

MeshContents read_medit(std::string_view bytes) {
  MeditReader reader(bytes);
  return FileText(bytes).peek().starts_with("MeshVersion") ? reader.read_text() : reader.read_binary();
}

}  // namespace acus
