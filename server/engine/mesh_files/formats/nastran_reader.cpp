// SPDX-License-Identifier: GPL-3.0-or-later
// Bulk data: a card is a name and fields, over several lines. Fields are separated by commas, or 8 columns wide, or 16
// where the name ends in "*". Nodes with a coordinate system of their own and included files are refused.
#include <cmath>

#include "server/engine/mesh_files/formats/readers.h"
#include "server/engine/models/geometry/tetrahedral_mesh.h"

namespace acus {
namespace {

// By the number of corners; each has a quadratic twin.
struct CardType {
  std::string_view name;
  Shape shape;
  std::array<std::size_t, 2> nodes;
};

constexpr std::array<CardType, 5> kSolidCards{{
    {"CTETRA", Shape::tetrahedron, {4, 10}},
    {"CPYRAM", Shape::pyramid, {5, 13}},
    {"CPYRA", Shape::pyramid, {5, 13}},
    {"CPENTA", Shape::prism, {6, 15}},
    {"CHEXA", Shape::hexahedron, {8, 20}},
}};

constexpr std::array<std::pair<std::string_view, const char*>, 10> kFlatCards{{
    {"CTRIA", "triangles"},
    {"CQUAD", "quadrangles"},
    {"CSHEAR", "quadrangles"},
    {"CBAR", "lines"},
    {"CBEAM", "lines"},
    {"CROD", "lines"},
    {"CTUBE", "lines"},
    {"CELAS", "springs"},
    {"CBUSH", "springs"},
    {"CONM", "masses"},
}};

// A card and what its name is followed by, over all its lines.
struct Card {
  std::string name;
  std::size_t at = 0;
  std::vector<std::string> fields;
};

// A tab goes on to the next column of 8.
std::string with_columns(std::string_view line) {
  std::string columns;
  for (const char c : line) {
    if (c == '\t')
      columns.append(8 - columns.size() % 8, ' ');
    else
      columns += c;
  }
  return columns;
}

// One line: its first field, the name or what continues a card, and the fields behind it.
struct CardLine {
  std::string first;
  std::vector<std::string> fields;
  std::size_t room = 8;  // fields that a line of this form has
};

CardLine parse_line(std::string_view text) {
  CardLine line;
  if (text.find(',') != std::string_view::npos) {
    const std::vector<std::string_view> parts = split(text, ',');
    line.first = parts[0];
    if (line.first.find('*') != std::string::npos) line.room = 4;
    // The tenth part marks what continues the card, unless a program has put all fields into one line.
    const bool marked = parts.size() > 1 + line.room && !parse_integer(parts[1 + line.room]);
    for (std::size_t i = 1; i < (marked ? 1 + line.room : parts.size()); ++i)
      if (!parts[i].starts_with('+') || parse_real(parts[i])) line.fields.emplace_back(parts[i]);
    line.room = std::max(line.room, line.fields.size());
    return line;
  }
  const std::string columns = with_columns(text);
  line.first = trimmed(std::string_view(columns).substr(0, 8));
  const bool wide = line.first.find('*') != std::string::npos;
  const std::size_t width = wide ? 16 : 8;
  line.room = 64 / width;
  for (std::size_t begin = 8; begin < std::min<std::size_t>(72, columns.size()); begin += width)
    line.fields.emplace_back(trimmed(std::string_view(columns).substr(begin, width)));
  return line;
}

class NastranReader {
 public:
  explicit NastranReader(std::string_view bytes) : file_(bytes), groups_(contents_.groups) {}

  MeshContents read() {
    contents_.format = "Nastran";
    skip_control();
    while (file_.left() > 0 && card_.name != "ENDDATA") {
      const std::size_t at = file_.at();
      read_line(at, file_.line());
    }
    take_card();
    if (card_.name != "ENDDATA") contents_.remarks.emplace_back("no ENDDATA: the file may be cut off");
    return std::move(contents_);
  }

 private:
  // What stands before the bulk data, where these are marked.
  void skip_control() {
    while (file_.left() > 0) {
      const std::string line = in_capitals(trimmed(file_.line()));
      if (line.starts_with("BEGIN") && line.find("BULK") != std::string::npos) return;
    }
    file_.go_to(0);
  }

  void read_line(std::size_t at, std::string_view text) {
    text = text.substr(0, text.find('$'));
    if (trimmed(text).empty()) return;
    CardLine line = parse_line(text);
    const bool continues = line.first.empty() || line.first[0] == '+' || line.first[0] == '*';
    if (continues) {
      card_.fields.resize(room_);
    } else {
      take_card();
      card_ = {in_capitals(line.first), at, {}};
      if (card_.name.ends_with('*')) card_.name.pop_back();
      room_ = 0;
    }
    room_ += line.room;
    card_.fields.insert(card_.fields.end(), line.fields.begin(), line.fields.end());
  }

  void take_card() {
    while (!card_.fields.empty() && card_.fields.back().empty()) card_.fields.pop_back();
    if (card_.name == "GRID") return take_node();
    if (card_.name == "INCLUDE" || card_.name.starts_with("INCLUDE"))
      file_.fail_at(card_.at, "included files are not read; put all cards into one file");
    if (card_.name == "GRDSET" && !field(1).empty() && field(1) != "0") refuse_system();
    for (const CardType& type : kSolidCards)
      if (card_.name == type.name) return take_element(type);
    for (const auto& [name, kind] : kFlatCards)
      if (card_.name.starts_with(name)) ++contents_.left_out[kind];
  }

  [[noreturn]] void refuse_system() const {
    file_.fail_at(card_.at, "nodes in a coordinate system of their own (" + field(1) +
                                ") are not read; write them in the basic one");
  }

  void take_node() {
    if (!field(1).empty() && field(1) != "0") refuse_system();
    const std::int64_t number = whole(0, "a node number");
    if (number < 1) file_.fail_at(card_.at, "node number " + std::to_string(number) + ": numbers begin at 1");
    contents_.nodes.push_back({number, card_.at, {coordinate(2), coordinate(3), coordinate(4)}});
  }

  void take_element(const CardType& type) {
    const std::int64_t number = whole(0, "an element number");
    const std::int64_t property = field(1).empty() ? number : whole(1, "a property number");
    std::vector<std::int64_t> nodes;
    const std::size_t corners = type.nodes[0];
    // A quadratic element may lack nodes between corners; then it counts as one without any.
    bool complete = card_.fields.size() == 2 + type.nodes[1];
    for (std::size_t i = 2; complete && i < card_.fields.size(); ++i) complete = !card_.fields[i].empty();
    for (std::size_t i = 0; i < (complete ? type.nodes[1] : corners); ++i)
      nodes.push_back(whole(2 + i, "a node of the element"));
    if (card_.fields.size() > 2 + type.nodes[1])
      file_.fail_at(card_.at, card_.name + " has " + std::to_string(card_.fields.size() - 2) +
                                  " nodes, expected at most " + std::to_string(type.nodes[1]) +
                                  "; save it with linear elements");
    if (number < 1) file_.fail_at(card_.at, "element number " + std::to_string(number) + ": numbers begin at 1");
    groups_.of("", property).members.push_back(static_cast<int>(contents_.elements.size()));
    contents_.add_element({type.shape, nodes.size()}, number, card_.at, nodes);
  }

  std::string field(std::size_t i) const { return i < card_.fields.size() ? card_.fields[i] : ""; }

  std::int64_t whole(std::size_t i, const char* what) const {
    const std::optional<std::int64_t> value = parse_integer(field(i));
    if (!value) file_.fail_at(card_.at, card_.name + ": expected " + what + ", found " + in_quotes(field(i)));
    return *value;
  }

  double coordinate(std::size_t i) const {
    if (field(i).empty()) return 0;
    const std::optional<double> value = parse_real(field(i));
    if (!value || !std::isfinite(*value))
      file_.fail_at(card_.at, "expected a coordinate, found " + in_quotes(field(i)));
    return *value;
  }

  FileText file_;
  MeshContents contents_;
  GroupMaker groups_;
  Card card_;
  std::size_t room_ = 0;  // fields of the card's lines so far, empty ones too
};

}  // namespace

MeshContents read_nastran(std::string_view bytes) { return NastranReader(bytes).read(); }

}  // namespace acus
