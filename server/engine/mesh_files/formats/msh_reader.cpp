// SPDX-License-Identifier: GPL-3.0-or-later
// Gmsh's own format: https://gmsh.info/doc/texinfo/gmsh.html#Gmsh-file-formats
#include <cstdlib>

#include "server/engine/mesh_files/formats/readers.h"
#include "server/engine/models/geometry/tetrahedral_mesh.h"

namespace acus {
namespace {

constexpr int kVolume = 3;  // dimension

// Gmsh's number of an element type. Those without volume have a number of nodes and a name alone.
struct MshType {
  int number;
  std::size_t nodes;
  const char* flat;  // what is counted, or null for a volume
  ElementType volume;
};

// Gmsh numbers the last two middles of a tetrahedron the other way round than the others.
constexpr ElementType kTetrahedron10{Shape::tetrahedron, 10, {0, 1, 2, 3, 4, 5, 6, 7, 9, 8}};

constexpr ElementType volume_type(Shape shape, std::size_t nodes) { return {shape, nodes}; }

constexpr std::array<MshType, 43> kMshTypes{{
    {15, 1, "points", {}},
    {1, 2, "lines", {}},
    {8, 3, "lines", {}},
    {26, 4, "lines", {}},
    {27, 5, "lines", {}},
    {28, 6, "lines", {}},
    {2, 3, "triangles", {}},
    {9, 6, "triangles", {}},
    {20, 9, "triangles", {}},
    {21, 10, "triangles", {}},
    {22, 12, "triangles", {}},
    {23, 15, "triangles", {}},
    {24, 15, "triangles", {}},
    {25, 21, "triangles", {}},
    {3, 4, "quadrangles", {}},
    {10, 9, "quadrangles", {}},
    {16, 8, "quadrangles", {}},
    {36, 16, "quadrangles", {}},
    {37, 25, "quadrangles", {}},
    {38, 36, "quadrangles", {}},
    {39, 12, "quadrangles", {}},
    {40, 16, "quadrangles", {}},
    {41, 20, "quadrangles", {}},
    {4, 4, nullptr, volume_type(Shape::tetrahedron, 4)},
    {11, 10, nullptr, kTetrahedron10},
    {29, 20, nullptr, volume_type(Shape::tetrahedron, 20)},
    {30, 35, nullptr, volume_type(Shape::tetrahedron, 35)},
    {31, 56, nullptr, volume_type(Shape::tetrahedron, 56)},
    {5, 8, nullptr, volume_type(Shape::hexahedron, 8)},
    {12, 27, nullptr, volume_type(Shape::hexahedron, 27)},
    {17, 20, nullptr, volume_type(Shape::hexahedron, 20)},
    {92, 64, nullptr, volume_type(Shape::hexahedron, 64)},
    {93, 125, nullptr, volume_type(Shape::hexahedron, 125)},
    {6, 6, nullptr, volume_type(Shape::prism, 6)},
    {13, 18, nullptr, volume_type(Shape::prism, 18)},
    {18, 15, nullptr, volume_type(Shape::prism, 15)},
    {90, 40, nullptr, volume_type(Shape::prism, 40)},
    {91, 75, nullptr, volume_type(Shape::prism, 75)},
    {7, 5, nullptr, volume_type(Shape::pyramid, 5)},
    {14, 14, nullptr, volume_type(Shape::pyramid, 14)},
    {19, 13, nullptr, volume_type(Shape::pyramid, 13)},
    {118, 30, nullptr, volume_type(Shape::pyramid, 30)},
    {119, 55, nullptr, volume_type(Shape::pyramid, 55)},
}};

class MshReader {
 public:
  explicit MshReader(std::string_view bytes) : file_(bytes), groups_(contents_.groups) {}

  MeshContents read() {
    bool any = false;
    while (!file_.peek().empty()) {
      const std::string_view section = file_.word("a section");
      if (section.front() != '$') file_.fail("expected the $ of a section, found " + in_quotes(section));
      section_at_ = file_.word_at();
      read_section(std::string(section.substr(1)));
      any |= section == "$Elements" || section == "$ELM";
    }
    if (!any) throw MeshError("the file has no section $Elements; it is cut off, or holds results alone");
    return std::move(contents_);
  }

 private:
  void read_section(const std::string& name) {
    if (name == "MeshFormat")
      read_format();
    else if (name == "PhysicalNames")
      read_names();
    else if (name == "Entities" || name == "PartitionedEntities")
      read_entities(name == "PartitionedEntities");
    else if (name == "Nodes")
      version_ < 3 ? read_nodes_2() : read_nodes_4();
    else if (name == "NOD" || name == "NOE")
      read_nodes_1();
    else if (name == "Elements")
      version_ < 3 ? read_elements_2() : read_elements_4();
    else if (name == "ELM")
      read_elements_1();
    else
      return pass_over(name);
    expect_end(name);
  }

  void pass_over(const std::string& name) {
    const std::size_t end = file_.bytes().find("$End" + name, file_.at());
    if (end == std::string_view::npos) file_.fail("section $" + name + " has no end; the file is cut off");
    file_.go_to(end + name.size() + 4);
  }

  void expect_end(const std::string& name) {
    const std::string old = name == "NOD" || name == "ELM" || name == "NOE" ? "$END" + name : "$End" + name;
    const std::string_view found = file_.peek();
    if (found == old) {
      file_.word("the end of the section");
      return;
    }
    const std::size_t at = file_.at();
    file_.fail_at(at, "expected " + old + ", since $" + name + " in " + file_.place(section_at_) +
                          " announces no more, " +
                          (found.empty() ? "found the end of the file; it is cut off" : "found " + in_quotes(found)));
  }

  void read_format() {
    version_ = file_.real("the version");
    const std::int64_t kind = file_.integer("0 for text or 1 for binary");
    size_bytes_ = file_.count("the bytes of a number");
    binary_ = kind == 1;
    const bool known = version_ == 2 || version_ == 2.1 || version_ == 2.2 || version_ == 4 || version_ == 4.1;
    if (!known) file_.fail("expected version 1, 2.x, 4.0 or 4.1 of Gmsh's format; save it as version 4.1 or 2.2");
    std::string digits = std::to_string(version_).substr(0, 3);
    contents_.format = "Gmsh " + digits + (binary_ ? ", binary" : "");
    if (!binary_) return;
    file_.line();
    const int one = file_.binary<int>("the number one in the file's byte order");
    if (one == 1) return;
    file_.swap_bytes(true);
    if (FileText::number_at<int>(reinterpret_cast<const char*>(&one), true) != 1)
      file_.fail("expected the number one in either byte order");
  }

  void read_names() {
    const std::size_t names = file_.count("the number of names");
    for (std::size_t i = 0; i < names; ++i) {
      const std::int64_t dimension = file_.integer("a dimension");
      const std::int64_t number = file_.integer("a physical group");
      std::string_view name = trimmed(file_.line());
      if (name.size() >= 2 && name.front() == '"' && name.back() == '"') name = name.substr(1, name.size() - 2);
      if (dimension == kVolume) names_[number] = std::string(name);
    }
  }

  // ---- Versions 1 and 2: every element tells its groups.

  void read_nodes_1() {
    if (contents_.format.empty()) contents_.format = "Gmsh 1";
    const std::size_t nodes = file_.count("the number of nodes");
    for (std::size_t i = 0; i < nodes; ++i) read_text_node();
  }

  void read_nodes_2() {
    const std::size_t nodes = file_.count("the number of nodes");
    if (!binary_) {
      for (std::size_t i = 0; i < nodes; ++i) read_text_node();
      return;
    }
    file_.line();
    for (std::size_t i = 0; i < nodes; ++i) {
      const std::size_t at = file_.at();
      const std::int64_t number = file_.binary<int>("a node");
      add_node(number, at, binary_place());
    }
  }

  void read_text_node() {
    const std::int64_t number = file_.integer("a node number");
    const std::size_t at = file_.word_at();
    const double x = file_.real("a coordinate"), y = file_.real("a coordinate"), z = file_.real("a coordinate");
    file_.expect_line_end("a node's coordinates");
    add_node(number, at, {x, y, z});
  }

  void add_node(std::int64_t number, std::size_t at, const std::array<double, 3>& x) {
    if (number < 1) file_.fail_at(at, "node number " + std::to_string(number) + ": numbers begin at 1");
    for (const double each : x)
      if (!std::isfinite(each)) file_.fail_at(at, "node " + std::to_string(number) + " is at no finite place");
    contents_.nodes.push_back({number, at, x});
  }

  std::array<double, 3> binary_place() {
    const double x = file_.binary<double>("a coordinate"), y = file_.binary<double>("a coordinate");
    return {x, y, file_.binary<double>("a coordinate")};
  }

  void read_elements_1() {
    const std::size_t elements = file_.count("the number of elements");
    for (std::size_t i = 0; i < elements; ++i) {
      const std::int64_t number = file_.integer("an element number");
      const std::size_t at = file_.word_at();
      const MshType& type = type_of(file_.integer("an element type"));
      const std::int64_t group = file_.integer("a physical group");
      file_.integer("an elementary group");
      const std::size_t nodes = file_.count("the number of the element's nodes");
      if (nodes != type.nodes)
        file_.fail("expected " + std::to_string(type.nodes) + " nodes, found " + std::to_string(nodes));
      read_text_element(type, number, at, {&group, 1});
    }
  }

  void read_elements_2() {
    const std::size_t elements = file_.count("the number of elements");
    if (binary_) return read_binary_elements_2(elements);
    for (std::size_t i = 0; i < elements; ++i) {
      const std::int64_t number = file_.integer("an element number");
      const std::size_t at = file_.word_at();
      const MshType& type = type_of(file_.integer("an element type"));
      const std::size_t tags = file_.count("the number of tags");
      std::int64_t group = 0;
      for (std::size_t t = 0; t < tags; ++t) {
        const std::int64_t tag = file_.integer("a tag");
        if (t == 0) group = tag;
      }
      read_text_element(type, number, at, {&group, 1});
    }
  }

  void read_binary_elements_2(std::size_t elements) {
    file_.line();
    for (std::size_t done = 0; done < elements;) {
      const MshType& type = type_of(file_.binary<int>("an element type"));
      const int block = file_.binary<int>("the number of elements of a type");
      const int tags = file_.binary<int>("the number of tags");
      if (block < 1 || static_cast<std::size_t>(block) > elements - done || tags < 0)
        file_.fail("expected a block of at most " + std::to_string(elements - done) + " elements");
      for (int i = 0; i < block; ++i) read_binary_element_2(type, tags);
      done += static_cast<std::size_t>(block);
    }
  }

  void read_binary_element_2(const MshType& type, int tags) {
    const std::size_t at = file_.at();
    const std::int64_t number = file_.binary<int>("an element");
    std::int64_t group = 0;
    for (int t = 0; t < tags; ++t) {
      const int tag = file_.binary<int>("a tag");
      if (t == 0) group = tag;
    }
    nodes_.clear();
    for (std::size_t i = 0; i < type.nodes; ++i) nodes_.push_back(file_.binary<int>("a node of an element"));
    add_element(type, number, at, {&group, 1});
  }

  void read_text_element(const MshType& type, std::int64_t number, std::size_t at,
                         std::span<const std::int64_t> element_groups) {
    nodes_.clear();
    for (std::size_t i = 0; i < type.nodes; ++i) nodes_.push_back(file_.integer("a node of the element"));
    file_.expect_line_end("the element's nodes");
    add_element(type, number, at, element_groups);
  }

  const MshType& type_of(std::int64_t number) {
    for (const MshType& type : kMshTypes)
      if (type.number == number) return type;
    file_.fail("expected an element type that Gmsh knows, found " + std::to_string(number));
  }

  void add_element(const MshType& type, std::int64_t number, std::size_t at,
                   std::span<const std::int64_t> element_groups) {
    if (number < 1) file_.fail_at(at, "element number " + std::to_string(number) + ": numbers begin at 1");
    if (type.flat) {
      ++contents_.left_out[type.flat];
      return;
    }
    const int element = static_cast<int>(contents_.elements.size());
    contents_.add_element(type.volume, number, at, nodes_);
    for (const std::int64_t tag : element_groups) {
      if (tag == 0) continue;
      MeshGroup& group = groups_.of("", std::abs(tag));
      const auto name = names_.find(std::abs(tag));
      if (group.name.empty() && name != names_.end()) group.name = name->second;
      group.members.push_back(element);
    }
  }

  // ---- Version 4: elements belong to entities, which tell the groups.

  // Words of a text, or binary numbers of one kind.
  std::int64_t whole(const char* what) { return binary_ ? file_.binary<int>(what) : file_.integer(what); }
  std::int64_t size(const char* what) {
    if (!binary_) return file_.integer(what);
    return size_bytes_ == 4 ? file_.binary<std::uint32_t>(what)
                            : static_cast<std::int64_t>(file_.binary<std::uint64_t>(what));
  }
  std::size_t size_of(const char* what) {
    const std::int64_t value = size(what);
    if (value < 0) file_.fail(std::string("expected ") + what + ", found " + std::to_string(value));
    return static_cast<std::size_t>(value);
  }
  // Node and element numbers: of the size of a pointer from 4.1 on.
  std::int64_t tag(const char* what) { return version_ > 4 ? size(what) : whole(what); }
  double real(const char* what) { return binary_ ? file_.binary<double>(what) : file_.real(what); }
  void begin_binary() {
    if (binary_) file_.line();
  }
  void end_text_line(const char* after) {
    if (!binary_) file_.expect_line_end(after);
  }

  void read_entities(bool partitioned) {
    if (partitioned && version_ < 4.1) file_.fail("partitioned meshes are read from version 4.1 on; save it as 4.1");
    begin_binary();
    if (partitioned) {
      size("the number of partitions");
      const std::size_t ghosts = size_of("the number of ghost entities");
      for (std::size_t i = 0; i < 2 * ghosts; ++i) whole("a ghost entity");
    }
    std::array<std::size_t, 4> counts{};
    for (std::size_t& count : counts) count = size_of("a number of entities");
    for (int dimension = 0; dimension < 4; ++dimension)
      for (std::size_t i = 0; i < counts[static_cast<std::size_t>(dimension)]; ++i) read_entity(dimension, partitioned);
  }

  void read_entity(int dimension, bool partitioned) {
    const std::int64_t entity = whole("the number of an entity");
    if (partitioned) {
      whole("a dimension"), whole("an entity");
      const std::size_t partitions = size_of("the number of partitions of an entity");
      for (std::size_t i = 0; i < partitions; ++i) whole("a partition");
    }
    const int bounds = dimension == 0 && version_ > 4 ? 3 : 6;
    for (int i = 0; i < bounds; ++i) real("a bound of an entity");
    const std::size_t physical = size_of("the number of an entity's physical groups");
    for (std::size_t i = 0; i < physical; ++i) {
      const std::int64_t group = whole("a physical group");
      if (dimension == kVolume) groups_of_volume_[entity].push_back(group);
    }
    if (dimension == 0) return;
    const std::size_t boundaries = size_of("the number of an entity's boundaries");
    for (std::size_t i = 0; i < boundaries; ++i) whole("a boundary of an entity");
  }

  void read_nodes_4() {
    begin_binary();
    const std::size_t blocks = size_of("the number of blocks");
    const std::size_t nodes = size_of("the number of nodes");
    if (version_ > 4) size("the smallest number"), size("the largest number");
    for (std::size_t i = 0; i < blocks; ++i) read_node_block();
    if (contents_.nodes.size() != nodes)
      file_.fail_at(section_at_, "$Nodes announces " + std::to_string(nodes) + " nodes, its blocks hold " +
                                     std::to_string(contents_.nodes.size()));
  }

  void read_node_block() {
    const std::int64_t first = whole("a dimension"), second = whole("an entity");
    const std::int64_t dimension = version_ > 4 ? first : second;
    const bool parametric = whole("0 or 1 for parametric nodes") != 0;
    const std::size_t nodes = size_of("the number of nodes in a block");
    const std::int64_t parameters = parametric ? dimension : 0;
    if (parameters < 0 || parameters > 3) file_.fail("expected a dimension from 0 to 3");
    if (version_ > 4) return read_split_nodes(nodes, parameters);
    for (std::size_t i = 0; i < nodes; ++i) {
      const std::int64_t number = tag("a node number");
      const std::size_t at = binary_ ? file_.at() : file_.word_at();
      add_node_4(number, at, parameters);
    }
  }

  // From 4.1 on a block has all numbers before all places.
  void read_split_nodes(std::size_t nodes, std::int64_t parameters) {
    std::vector<std::pair<std::int64_t, std::size_t>> numbers;
    for (std::size_t i = 0; i < nodes; ++i) {
      const std::int64_t number = tag("a node number");
      numbers.emplace_back(number, binary_ ? file_.at() : file_.word_at());
    }
    for (const auto& [number, at] : numbers) add_node_4(number, at, parameters);
  }

  void add_node_4(std::int64_t number, std::size_t at, std::int64_t parameters) {
    std::array<double, 3> x{};
    for (double& each : x) each = real("a coordinate");
    for (std::int64_t i = 0; i < parameters; ++i) real("a parameter of a node");
    end_text_line("a node's coordinates");
    add_node(number, at, x);
  }

  void read_elements_4() {
    begin_binary();
    const std::size_t blocks = size_of("the number of blocks");
    const std::size_t elements = size_of("the number of elements");
    if (version_ > 4) size("the smallest number"), size("the largest number");
    std::size_t found = 0;
    for (std::size_t i = 0; i < blocks; ++i) found += read_element_block();
    if (found != elements)
      file_.fail_at(section_at_, "$Elements announces " + std::to_string(elements) + " elements, its blocks hold " +
                                     std::to_string(found));
  }

  std::size_t read_element_block() {
    const std::int64_t first = whole("a dimension"), second = whole("an entity");
    const std::int64_t entity = version_ > 4 ? second : first;
    const MshType& type = type_of(whole("an element type"));
    const std::size_t elements = size_of("the number of elements in a block");
    const auto groups = groups_of_volume_.find(entity);
    const std::span<const std::int64_t> its_groups =
        groups == groups_of_volume_.end() ? std::span<const std::int64_t>() : groups->second;
    for (std::size_t i = 0; i < elements; ++i) {
      const std::size_t before = file_.at();
      const std::int64_t number = tag("an element number");
      const std::size_t at = binary_ ? before : file_.word_at();
      nodes_.clear();
      for (std::size_t n = 0; n < type.nodes; ++n) nodes_.push_back(tag("a node of the element"));
      end_text_line("the element's nodes");
      add_element(type, number, at, its_groups);
    }
    return elements;
  }

  FileText file_;
  MeshContents contents_;
  GroupMaker groups_;
  double version_ = 1;
  bool binary_ = false;
  std::size_t size_bytes_ = 8;
  std::size_t section_at_ = 0;
  std::map<std::int64_t, std::string> names_;
  std::map<std::int64_t, std::vector<std::int64_t>> groups_of_volume_;
  std::vector<std::int64_t> nodes_;  // of the element that is read
};

}  // namespace

MeshContents read_msh(std::string_view bytes) { return MshReader(bytes).read(); }

}  // namespace acus
