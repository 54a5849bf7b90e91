// SPDX-License-Identifier: GPL-3.0-or-later
// Input of Abaqus and CalculiX: keywords in lines that begin with "*", parameters behind commas, data lines until the
// next keyword. Numbers belong to a part; an instance places a part in the assembly. Keywords that make nodes or
// elements of others, and included files, are refused.
#include <cmath>
#include <numbers>
#include <optional>

#include "server/engine/mesh_files/formats/readers.h"
#include "server/engine/models/geometry/tetrahedral_mesh.h"

namespace acus {
namespace {

struct Keyword {
  std::string name;                                            // in capitals, without "*"
  std::map<std::string, std::string, std::less<>> parameters;  // names in capitals; texts as they stand
  std::size_t at = 0;

  std::string of(std::string_view parameter) const {
    const auto found = parameters.find(parameter);
    return found == parameters.end() ? "" : found->second;
  }
};

// Of C3D4, C3D10M, DC3D8, AC3D20R, F3D4 and the like: what stands behind "3D" is the number of nodes. Nothing for types
// without volume.
std::optional<ElementType> volume_of(const std::string& type, const Keyword& keyword, const FileText& file) {
  const std::size_t family = type.starts_with("F3D") ? 0 : type.find("C3D");
  if (family == std::string::npos) return std::nullopt;
  const std::size_t begin = type.find("3D", family) + 2;
  const std::size_t end = std::min(type.find_first_not_of("0123456789", begin), type.size());
  for (const auto& [shape, nodes] : std::initializer_list<std::pair<Shape, std::size_t>>{{Shape::tetrahedron, 4},
                                                                                         {Shape::tetrahedron, 10},
                                                                                         {Shape::pyramid, 5},
                                                                                         {Shape::pyramid, 13},
                                                                                         {Shape::prism, 6},
                                                                                         {Shape::prism, 15},
                                                                                         {Shape::hexahedron, 8},
                                                                                         {Shape::hexahedron, 20},
                                                                                         {Shape::hexahedron, 27}})
    if (type.substr(begin, end - begin) == std::to_string(nodes)) return ElementType{shape, nodes};
  file.fail_at(keyword.at,
               "elements of type " + type + " are not read; use C3D4, C3D10, C3D5, C3D6, C3D8 or their twins");
}

// What stands between *PART and *END PART, or outside of all parts.
struct Part {
  std::string name;
  std::vector<MeshNode> nodes;
  std::vector<MeshElement> elements;
  std::map<std::int64_t, int> element_of_number;
  struct Set {
    std::string name;  // as it is spelt first
    std::vector<int> elements;
  };
  std::map<std::string, Set> sets;  // by names in capitals: upper and lower case are the same
};

struct Instance {
  std::size_t part;
  std::string name;
  std::vector<double> placement;  // of its data lines: translation, then two points of an axis and an angle (degrees)
  std::map<std::string, Part::Set> sets;  // that the assembly defines
};

// x' = R x + t, in Abaqus' order: translated, then turned.
struct Placement {
  explicit Placement(std::vector<double> n) {
    n.resize(10);
    offset = Vector3(&n[0]);
    const Vector3 begin(&n[3]), axis = Vector3(&n[6]) - begin;
    if (axis.norm() == 0) return;
    rotation = Eigen::AngleAxisd(n[9] * (std::numbers::pi / 180), axis.normalized()).toRotationMatrix();
    offset = (rotation * (offset - begin) + begin).eval();
  }
  std::array<double, 3> operator()(const std::array<double, 3>& x) const {
    const Vector3 moved = rotation * Vector3(x.data()) + offset;
    return {moved.x(), moved.y(), moved.z()};
  }

  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Vector3 offset = Vector3::Zero();
};

class AbaqusReader {
 public:
  explicit AbaqusReader(std::string_view bytes) : file_(bytes), parts_(1) { contents_.format = "Abaqus"; }

  MeshContents read() {
    while (file_.left() > 0) {
      const std::size_t at = file_.at();
      const std::string_view line = trimmed(file_.line());
      if (line.empty() || line.starts_with("**")) continue;
      if (line[0] == '*')
        begin_keyword(parse_keyword(at, line));
      else
        read_data(at, line);
    }
    expect_whole_element();
    assemble();
    return std::move(contents_);
  }

 private:
  // Parameters go on in the next line where this one ends with a comma.
  Keyword parse_keyword(std::size_t at, std::string_view line) {
    std::string text(line);
    while (text.ends_with(',') && file_.left() > 0) text += trimmed(file_.line());
    const std::vector<std::string_view> parts = split(std::string_view(text).substr(1), ',');
    Keyword keyword{in_capitals(parts[0]), {}, at};
    std::erase(keyword.name, ' ');
    for (const std::string_view part : std::span(parts).subspan(1)) {
      const std::size_t equals = std::min(part.find('='), part.size());
      std::string_view value = trimmed(part.substr(std::min(equals + 1, part.size())));
      if (value.size() >= 2 && value.front() == '"' && value.back() == '"') value = value.substr(1, value.size() - 2);
      keyword.parameters[in_capitals(trimmed(part.substr(0, equals)))] = value;
    }
    return keyword;
  }

  void begin_keyword(Keyword keyword) {
    expect_whole_element();
    keyword_ = std::move(keyword);
    const std::string& name = keyword_.name;
    refuse_what_makes_others();
    if (name == "PART") {
      part_ = parts_.size();
      parts_.emplace_back().name = in_capitals(keyword_.of("NAME"));
    } else if (name == "ENDPART") {
      part_ = 0;
    } else if (name == "INSTANCE") {
      begin_instance();
    } else if (name == "ELEMENT") {
      type_ = volume_of(in_capitals(keyword_.of("TYPE")), keyword_, file_);
    }
    set_ = name == "ELEMENT" || name == "ELSET" ? find_set(keyword_.of("ELSET")) : nullptr;
  }

  void refuse_what_makes_others() const {
    const std::string& name = keyword_.name;
    for (const char* refused : {"INCLUDE", "NGEN", "NFILL", "NCOPY", "ELGEN", "ELCOPY", "NMAP", "SYSTEM"})
      if (name == refused)
        file_.fail_at(keyword_.at, "*" + name + " is not read; list all nodes and elements in one file");
    if (name != "NODE" && name != "ELEMENT") return;
    if (!keyword_.of("INPUT").empty())
      file_.fail_at(keyword_.at, "*" + name + " with INPUT is not read; list all nodes and elements in one file");
    const std::string system = in_capitals(keyword_.of("SYSTEM"));
    if (!system.empty() && system != "R")
      file_.fail_at(keyword_.at, "nodes in SYSTEM=" + system + " are not read; write rectangular coordinates");
  }

  void begin_instance() {
    const std::string wanted = in_capitals(keyword_.of("PART"));
    const auto named = [&wanted](const Part& part) { return !part.name.empty() && part.name == wanted; };
    const auto found = std::find_if(parts_.begin(), parts_.end(), named);
    if (found == parts_.end())
      file_.fail_at(keyword_.at,
                    "the instance is of part " + in_quotes(keyword_.of("PART")) + ", which is not before it");
    instances_.push_back({static_cast<std::size_t>(found - parts_.begin()), keyword_.of("NAME"), {}, {}});
  }

  Instance* instance_of_set() {
    const std::string wanted = in_capitals(keyword_.of("INSTANCE"));
    for (Instance& instance : instances_)
      if (!wanted.empty() && in_capitals(instance.name) == wanted) return &instance;
    return nullptr;
  }

  // A set of the instance that the keyword names, else of the part; null without a name.
  Part::Set* find_set(const std::string& name) {
    if (name.empty()) return nullptr;
    Instance* instance = instance_of_set();
    set_part_ = instance ? instance->part : part_;
    Part::Set& set = (instance ? instance->sets : parts_[part_].sets)[in_capitals(name)];
    if (set.name.empty()) set.name = name;
    return &set;
  }

  void read_data(std::size_t at, std::string_view line) {
    if (keyword_.name == "NODE") return read_node(at, line);
    if (keyword_.name == "ELEMENT") return read_element(at, line);
    if (keyword_.name == "ELSET") return read_set(at, line);
    if (keyword_.name == "INSTANCE")
      for (const std::string_view part : split(line, ','))
        instances_.back().placement.push_back(parse_real(part).value_or(0));
  }

  std::int64_t whole(std::size_t at, std::string_view text, const char* what) const {
    const std::optional<std::int64_t> value = parse_integer(text);
    if (!value) file_.fail_at(at, std::string("expected ") + what + ", found " + in_quotes(text));
    if (*value < 1) file_.fail_at(at, std::string(what) + " " + std::to_string(*value) + ": numbers begin at 1");
    return *value;
  }

  void read_node(std::size_t at, std::string_view line) {
    const std::vector<std::string_view> parts = split(line, ',');
    MeshNode node{whole(at, parts[0], "node number"), at, {}};
    for (std::size_t i = 0; i < std::min<std::size_t>(3, parts.size() - 1); ++i) {
      if (parts[i + 1].empty()) continue;
      const std::optional<double> x = parse_real(parts[i + 1]);
      if (!x || !std::isfinite(*x)) file_.fail_at(at, "expected a coordinate, found " + in_quotes(parts[i + 1]));
      node.x[i] = *x;
    }
    parts_[part_].nodes.push_back(node);
  }

  // Over as many lines as the type has nodes for; of types without volume, until a line does not end with a comma.
  void read_element(std::size_t at, std::string_view line) {
    if (numbers_.empty()) element_at_ = at;
    for (const std::string_view part : split(line, ','))
      if (!part.empty()) numbers_.push_back(whole(at, part, numbers_.empty() ? "element number" : "node number"));
    if (!type_) {
      if (!line.ends_with(','))
        ++contents_.left_out["elements of type " + in_capitals(keyword_.of("TYPE"))], numbers_.clear();
      return;
    }
    if (numbers_.size() < 1 + type_->nodes) return;
    if (numbers_.size() > 1 + type_->nodes)
      file_.fail_at(at, "the element has " + std::to_string(numbers_.size() - 1) + " nodes, expected " +
                            std::to_string(type_->nodes));
    add_element();
    numbers_.clear();
  }

  void add_element() {
    Part& part = parts_[part_];
    const int element = static_cast<int>(part.elements.size());
    const auto [entry, is_new] = part.element_of_number.try_emplace(numbers_[0], element);
    if (!is_new)
      file_.fail_at(element_at_, "element number " + std::to_string(numbers_[0]) + " stands twice, first in " +
                                     file_.place(part.elements[static_cast<std::size_t>(entry->second)].at) +
                                     "; number elements once each");
    MeshContents one;
    one.add_element(*type_, numbers_[0], element_at_, std::span(numbers_).subspan(1));
    part.elements.push_back(one.elements[0]);
    if (set_) set_->elements.push_back(element);
  }

  void expect_whole_element() const {
    if (numbers_.empty()) return;
    file_.fail_at(element_at_, "element " + std::to_string(numbers_[0]) + " has " +
                                   std::to_string(numbers_.size() - 1) + " nodes, too few for " + keyword_.of("TYPE"));
  }

  void read_set(std::size_t at, std::string_view line) {
    if (!set_) file_.fail_at(keyword_.at, "expected *ELSET with ELSET=NAME");
    const std::vector<std::string_view> parts = split(line, ',');
    if (keyword_.parameters.contains("GENERATE")) return read_range(at, parts);
    for (const std::string_view part : parts) {
      if (part.empty()) continue;
      if (parse_integer(part))
        add_to_set(whole(at, part, "element number"));
      else
        add_set_to_set(at, part);
    }
  }

  void read_range(std::size_t at, const std::vector<std::string_view>& parts) {
    const std::int64_t first = whole(at, parts[0], "element number");
    const std::int64_t last = parts.size() > 1 ? whole(at, parts[1], "element number") : first;
    const std::int64_t step = parts.size() > 2 && !parts[2].empty() ? whole(at, parts[2], "step") : 1;
    const std::map<std::int64_t, int>& known = parts_[set_part_].element_of_number;
    for (auto next = known.lower_bound(first); next != known.end() && next->first <= last; ++next)
      if ((next->first - first) % step == 0) set_->elements.push_back(next->second);
  }

  // Elements without volume may be in sets, too, and are not known here.
  void add_to_set(std::int64_t number) {
    const std::map<std::int64_t, int>& known = parts_[set_part_].element_of_number;
    const auto element = known.find(number);
    if (element != known.end()) set_->elements.push_back(element->second);
  }

  void add_set_to_set(std::size_t at, std::string_view name) {
    const auto other = parts_[set_part_].sets.find(in_capitals(name));
    if (other == parts_[set_part_].sets.end()) {
      contents_.remarks.push_back(file_.place(at) + ": the set names " + in_quotes(name) +
                                  ", which is no set before it");
      return;
    }
    const std::vector<int> elements = other->second.elements;
    set_->elements.insert(set_->elements.end(), elements.begin(), elements.end());
  }

  // ---- All parts in one

  void assemble() {
    place_parts();
    const bool several = instances_.size() > 1;
    for (const Instance& instance : instances_) {
      const int first = static_cast<int>(contents_.elements.size());
      const bool named = several && !instance.name.empty();
      append(instance);
      append_sets(parts_[instance.part].sets, first, named ? instance.name + "." : "");
      append_sets(instance.sets, first, named ? instance.name + "." : "");
      if (named) append_sets({{"", {instance.name, every_element(instance)}}}, first, "");
    }
  }

  // What stands outside of all parts is there once; a part is where its instances place it, without any in a file of
  // none.
  void place_parts() {
    const bool placed = !instances_.empty();
    for (std::size_t part = 0; part < parts_.size(); ++part) {
      if (parts_[part].elements.empty()) continue;
      if (part == 0 || !placed)
        instances_.push_back({part, parts_[part].name, {}, {}});
      else if (!is_placed(part))
        contents_.left_out["elements of part " + parts_[part].name + ", which has no instance"] =
            parts_[part].elements.size();
    }
  }

  bool is_placed(std::size_t part) const {
    return std::any_of(instances_.begin(), instances_.end(), [&](const Instance& i) { return i.part == part; });
  }

  std::vector<int> every_element(const Instance& instance) const {
    std::vector<int> all(parts_[instance.part].elements.size());
    for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<int>(i);
    return all;
  }

  // Numbers of nodes go on from one instance to the next; those of elements are known to be different in a part.
  void append(const Instance& instance) {
    const Part& part = parts_[instance.part];
    const Placement place(instance.placement);
    const std::int64_t offset = largest_node_;
    for (const MeshNode& node : part.nodes) {
      contents_.nodes.push_back({node.number + offset, node.at, instance.placement.empty() ? node.x : place(node.x)});
      largest_node_ = std::max(largest_node_, node.number + offset);
    }
    for (MeshElement element : part.elements) {
      element.number = 0;
      for (std::int64_t& node : element.nodes) node += offset;
      contents_.elements.push_back(element);
    }
  }

  void append_sets(const std::map<std::string, Part::Set>& sets, int first, const std::string& prefix) {
    for (const auto& [key, set] : sets) {
      MeshGroup& group = contents_.groups.emplace_back();
      group.name = prefix + set.name;
      for (const int element : set.elements) group.members.push_back(first + element);
    }
  }

  FileText file_;
  MeshContents contents_;
  std::vector<Part> parts_;  // the first holds what stands outside of all parts
  std::vector<Instance> instances_;
  std::size_t part_ = 0, set_part_ = 0;
  Keyword keyword_;
  Part::Set* set_ = nullptr;           // that elements or data lines of the keyword go into
  std::optional<ElementType> type_;    // of the elements; none where they have no volume
  std::vector<std::int64_t> numbers_;  // of the element that is read: its own, its nodes'
  std::size_t element_at_ = 0;
  std::int64_t largest_node_ = 0;
};

}  // namespace

MeshContents read_abaqus(std::string_view bytes) { return AbaqusReader(bytes).read(); }

}  // namespace acus
