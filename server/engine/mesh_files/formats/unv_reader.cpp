// SPDX-License-Identifier: GPL-3.0-or-later
// Universal files: data sets between lines "-1", each with a number. 15, 781 and 2411 hold nodes, 2412 elements, 2467
// and its relatives named groups. https://www.ceas3.uc.edu/sdrluff/all.php
#include <cmath>

#include "server/engine/mesh_files/formats/readers.h"
#include "server/engine/models/geometry/tetrahedral_mesh.h"

namespace acus {
namespace {

// Nodes of a quadratic element go around each face, with those between corners in their places.
constexpr std::array<std::pair<std::int64_t, ElementType>, 8> kUnvVolumes{{
    {111, {Shape::tetrahedron, 4}},
    {118, {Shape::tetrahedron, 10, {0, 2, 4, 9, 1, 3, 5, 6, 7, 8}}},
    {312, {Shape::pyramid, 5}},
    {313, {Shape::pyramid, 13, {0, 2, 4, 6, 12}}},
    {112, {Shape::prism, 6}},
    {113, {Shape::prism, 15, {0, 2, 4, 9, 11, 13}}},
    {115, {Shape::hexahedron, 8}},
    {116, {Shape::hexahedron, 20, {0, 2, 4, 6, 12, 14, 16, 18}}},
}};

class UnvReader {
 public:
  explicit UnvReader(std::string_view bytes) : file_(bytes), groups_(contents_.groups) {}

  MeshContents read() {
    contents_.format = "UNV";
    while (!file_.peek().empty()) {
      file_.expect("-1", "between which a data set stands");
      if (!file_.peek().empty()) read_set();
    }
    name_groups();
    return std::move(contents_);
  }

 private:
  void read_set() {
    const std::int64_t set = file_.integer("the number of a data set");
    file_.line();
    if (set == 2411 || set == 781)
      read_nodes(true);
    else if (set == 15)
      read_nodes(false);
    else if (set == 2412)
      read_elements();
    else if (set == 2467 || set == 2477 || set == 2452 || set == 2435)
      read_groups();
    else
      return pass_over(set);
    file_.expect("-1", "which ends a data set");
  }

  void pass_over(std::int64_t set) {
    while (file_.left() > 0)
      if (trimmed(file_.line()) == "-1") return;
    throw MeshError("data set " + std::to_string(set) + " has no end; the file is cut off");
  }

  bool at_end_of_set() { return file_.peek() == "-1" || file_.peek().empty(); }

  void read_nodes(bool two_lines) {
    while (!at_end_of_set()) {
      const std::int64_t number = file_.integer("a node number");
      const std::size_t at = file_.word_at();
      for (int i = 0; i < 3; ++i) file_.integer("a coordinate system or a colour");
      if (two_lines) file_.expect_line_end("a node's colour");
      const double x = file_.real("a coordinate"), y = file_.real("a coordinate"), z = file_.real("a coordinate");
      file_.expect_line_end("a node's coordinates");
      if (number < 1) file_.fail_at(at, "node number " + std::to_string(number) + ": numbers begin at 1");
      contents_.nodes.push_back({number, at, {x, y, z}});
    }
  }

  void read_elements() {
    while (!at_end_of_set()) {
      const std::int64_t number = file_.integer("an element number");
      const std::size_t at = file_.word_at();
      const std::int64_t type = file_.integer("an element type");
      const std::int64_t property = file_.integer("a property number");
      const std::int64_t material = file_.integer("a material number");
      file_.integer("a colour");
      const std::size_t nodes = file_.count("the number of the element's nodes");
      file_.expect_line_end("the number of the element's nodes");
      if (is_beam(type)) pass_orientation(nodes);
      read_element({number, at, type, property, material}, nodes);
    }
  }

  static bool is_beam(std::int64_t type) { return type == 11 || (type >= 21 && type <= 24); }

  // A line before a beam's nodes, which some programs write for rods, too.
  void pass_orientation(std::size_t nodes) {
    const std::size_t begin = file_.at();
    FileText line(file_.line());
    std::size_t numbers = 0;
    while (!line.peek().empty()) line.word("a number"), ++numbers;
    if (numbers == nodes && nodes == 2) file_.go_to(begin);
  }

  struct Record {
    std::int64_t number;
    std::size_t at;
    std::int64_t type, property, material;
  };

  void read_element(const Record& record, std::size_t nodes) {
    const auto& [number, at, type, property, material] = record;
    constexpr std::size_t kMostNodes = 100;
    if (nodes > kMostNodes) file_.fail_at(at, "the element has " + std::to_string(nodes) + " nodes");
    std::vector<std::int64_t> its_nodes;
    for (std::size_t i = 0; i < nodes; ++i) its_nodes.push_back(file_.integer("a node of the element"));
    file_.expect_line_end("the element's nodes");
    for (const auto& [known, volume] : kUnvVolumes)
      if (known == type) return add(record, volume, its_nodes);
    if (type > 100 && type < 120)
      file_.fail_at(at, "solid elements of type " + std::to_string(type) +
                            " are not read; use type 111, 112, 115 or their quadratic twins");
    ++contents_.left_out["elements of type " + std::to_string(type)];
  }

  void add(const Record& record, const ElementType& volume, const std::vector<std::int64_t>& its_nodes) {
    const auto& [number, at, type, property, material] = record;
    if (its_nodes.size() != volume.nodes)
      file_.fail_at(at, "the element has " + std::to_string(its_nodes.size()) + " nodes, expected " +
                            std::to_string(volume.nodes) + "; save it with linear elements");
    if (number < 1) file_.fail_at(at, "element number " + std::to_string(number) + ": numbers begin at 1");
    const int element = static_cast<int>(contents_.elements.size());
    element_of_number_[number] = element;
    groups_.of("property", property).members.push_back(element);
    groups_.of("material", material).members.push_back(element);
    contents_.add_element(volume, number, at, its_nodes);
  }

  void read_groups() {
    while (!at_end_of_set()) {
      std::int64_t entries = 0;
      for (int i = 0; i < 8; ++i) entries = file_.integer("a number of a group");
      file_.expect_line_end("the number of a group's entries");
      NamedGroup& group = named_.emplace_back();
      group.name = trimmed(file_.line());
      for (std::int64_t i = 0; i < entries; ++i) {
        constexpr std::int64_t kElement = 8;
        const std::int64_t kind = file_.integer("a type of an entry"), number = file_.integer("an entry");
        file_.integer("a leaf"), file_.integer("a component");
        if (kind == kElement) group.elements.push_back(number);
      }
    }
  }

  void name_groups() {
    for (const NamedGroup& group : named_) {
      for (const std::int64_t number : group.elements) {
        const auto element = element_of_number_.find(number);
        if (element != element_of_number_.end()) groups_.of(group.name).members.push_back(element->second);
      }
    }
  }

  struct NamedGroup {
    std::string name;
    std::vector<std::int64_t> elements;  // numbers of the file
  };

  FileText file_;
  MeshContents contents_;
  GroupMaker groups_;
  std::map<std::int64_t, int> element_of_number_;
  std::vector<NamedGroup> named_;
};

}  // namespace

MeshContents read_unv(std::string_view bytes) { return UnvReader(bytes).read(); }

}  // namespace acus
