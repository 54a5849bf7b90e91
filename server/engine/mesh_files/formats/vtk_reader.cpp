// SPDX-License-Identifier: GPL-3.0-or-later
// VTK's legacy format: https://docs.vtk.org, "VTK file formats". From version 5.0 on cells are offsets and
// connectivity, and blocks METADATA, which end with an empty line, follow arrays. Binary numbers are big-endian.
#include <bit>
#include <cctype>

#include "server/engine/mesh_files/formats/readers.h"
#include "server/engine/mesh_files/formats/vtk_cells.h"
#include "server/engine/models/geometry/tetrahedral_mesh.h"

namespace acus {
namespace {

class VtkReader {
 public:
  explicit VtkReader(std::string_view bytes) : file_(bytes) {
    file_.swap_bytes(std::endian::native == std::endian::little);
  }

  MeshContents read() {
    read_header();
    while (!file_.peek().empty()) read_section(in_capitals(file_.word("a section")));
    if (!has_cells_) throw MeshError("expected CELLS, found none");
    const std::vector<int> element_of_cell = add_grid(grid_, contents_);
    add_cell_groups(grid_.cell_arrays, element_of_cell, contents_);
    return std::move(contents_);
  }

 private:
  void read_header() {
    const std::string_view first = file_.line();
    contents_.format =
        "VTK legacy " + std::string(trimmed(first.substr(std::min(first.size(), first.find("ersion") + 6))));
    file_.line();
    const std::string kind = in_capitals(file_.word("ASCII or BINARY"));
    if (kind != "ASCII" && kind != "BINARY") file_.fail("expected ASCII or BINARY, found " + in_quotes(kind));
    binary_ = kind == "BINARY";
    if (binary_) contents_.format += ", binary";
    const std::string dataset = in_capitals(file_.word("DATASET"));
    if (dataset != "DATASET") file_.fail("expected DATASET, found " + in_quotes(dataset));
    const std::string set = in_capitals(file_.word("the kind of data set"));
    if (set == "UNSTRUCTURED_GRID") return;
    if (set == "POLYDATA")
      throw MeshError(
          "expected an unstructured grid, found a surface (POLYDATA); fill it with tetrahedra, for instance with Gmsh "
          "or TetGen");
    file_.fail("expected UNSTRUCTURED_GRID, found " + set + "; in ParaView, Tetrahedralize makes one of it");
  }

  void read_section(const std::string& section) {
    if (section == "POINTS") return read_points();
    if (section == "CELLS") return read_cells();
    if (section == "CELL_TYPES") return read_types();
    if (section == "CELL_DATA") return begin_data(true);
    if (section == "POINT_DATA") return begin_data(false);
    if (section == "METADATA") return pass_metadata();
    if (section == "FIELD") return read_field();
    if (tuples_ || section == "LOOKUP_TABLE") return read_attribute(section);
    file_.fail("expected a section of an unstructured grid, found " + in_quotes(section));
  }

  void read_points() {
    const std::size_t points = file_.count("the number of points");
    grid_.points = read_array(3 * points, "points");
  }

  void read_cells() {
    has_cells_ = true;
    const std::size_t first = file_.count("the number of cells"), second = file_.count("the size of the cells");
    file_.line();
    const std::size_t begin = file_.at();
    if (file_.peek() == "OFFSETS") return read_offsets(first, second);
    file_.go_to(begin);
    const std::vector<std::int64_t> numbers = whole_numbers(second, "int", "CELLS");
    for (std::size_t i = 0; i < numbers.size();) {
      const std::int64_t size = numbers[i++];
      if (size < 0 || static_cast<std::size_t>(size) > numbers.size() - i)
        throw MeshError("CELLS: cell " + std::to_string(grid_.offsets.size()) + " has " + std::to_string(size) +
                        " points, more than follow");
      grid_.connectivity.insert(grid_.connectivity.end(), &numbers[i], &numbers[i] + size);
      grid_.offsets.push_back(static_cast<std::int64_t>(grid_.connectivity.size()));
      i += static_cast<std::size_t>(size);
    }
    if (grid_.offsets.size() != first)
      throw MeshError("CELLS announces " + std::to_string(first) + " cells, its numbers are " +
                      std::to_string(grid_.offsets.size()));
  }

  void read_offsets(std::size_t offsets, std::size_t entries) {
    file_.word("OFFSETS");
    std::vector<std::int64_t> all = read_whole_array(offsets, "OFFSETS");
    const std::string connectivity = in_capitals(file_.word("CONNECTIVITY"));
    if (connectivity != "CONNECTIVITY") file_.fail("expected CONNECTIVITY, found " + in_quotes(connectivity));
    grid_.connectivity = read_whole_array(entries, "CONNECTIVITY");
    if (!all.empty() && all.front() != 0)
      throw MeshError("OFFSETS: expected 0 first, found " + std::to_string(all.front()));
    if (!all.empty()) all.erase(all.begin());
    grid_.offsets = std::move(all);
  }

  void read_types() {
    const std::size_t cells = file_.count("the number of cell types");
    file_.line();
    grid_.types = whole_numbers(cells, "int", "CELL_TYPES");
  }

  void begin_data(bool of_cells) {
    of_cells_ = of_cells;
    tuples_ = file_.count("the number of tuples");
  }

  // To the first empty line.
  void pass_metadata() {
    file_.line();
    while (file_.left() > 0 && !trimmed(file_.line()).empty()) {
    }
  }

  void read_field() {
    file_.word("the name of the field");
    const std::size_t arrays = file_.count("the number of arrays");
    for (std::size_t i = 0; i < arrays; ++i) {
      const std::string_view name = file_.word("the name of an array");
      if (name == "METADATA") {
        pass_metadata();
        --i;
        continue;
      }
      const std::size_t components = file_.count("the number of components"),
                        tuples = file_.count("the number of tuples");
      keep(std::string(name), components, read_array(product(components, tuples), "an array"));
    }
  }

  void read_attribute(const std::string& kind) {
    const std::size_t tuples = tuples_.value_or(0);
    const std::string name(file_.word("the name of an array"));
    if (kind == "LOOKUP_TABLE") return pass_colours(file_.count("the size of the table"), 4);
    if (kind == "COLOR_SCALARS") return pass_colours(tuples, file_.count("the number of components"));
    if (kind == "SCALARS") return read_scalars(name, tuples);
    std::size_t components = 0;
    for (const auto& [known, count] : {std::pair{"VECTORS", 3},
                                       {"NORMALS", 3},
                                       {"TENSORS", 9},
                                       {"TENSORS6", 6},
                                       {"GLOBAL_IDS", 1},
                                       {"PEDIGREE_IDS", 1},
                                       {"EDGE_FLAGS", 1}})
      if (kind == known) components = static_cast<std::size_t>(count);
    if (kind == "TEXTURE_COORDINATES") components = file_.count("the number of components");
    if (components == 0) file_.fail("expected a section of an unstructured grid, found " + in_quotes(kind));
    read_array(product(components, tuples), "an array");
  }

  // SCALARS name type [components], then LOOKUP_TABLE name.
  void read_scalars(const std::string& name, std::size_t tuples) {
    const std::string type = in_lower(file_.word("a type"));
    const std::string_view rest = trimmed(file_.line());
    const std::size_t components = rest.empty() ? 1 : static_cast<std::size_t>(parse_integer(rest).value_or(1));
    const std::size_t begin = file_.at();
    if (in_capitals(file_.peek()) == "LOOKUP_TABLE")
      file_.line();
    else
      file_.go_to(begin);
    keep(name, components, numbers(product(components, tuples), type, "SCALARS"));
  }

  void pass_colours(std::size_t colours, std::size_t components) {
    file_.line();
    if (binary_)
      file_.take(product(colours, components), "colours");
    else
      for (std::size_t i = 0; i < colours * components; ++i) file_.real("a colour");
  }

  void keep(const std::string& name, std::size_t components, const std::vector<double>& values) {
    if (!of_cells_ || components != 1) return;
    if (std::optional whole = as_whole_numbers(values)) grid_.cell_arrays.push_back({decoded(name), std::move(*whole)});
  }

  // Names have %20 for a space.
  static std::string decoded(const std::string& name) {
    std::string plain;
    for (std::size_t i = 0; i < name.size(); ++i) {
      unsigned code = 0;
      const bool coded = name[i] == '%' && i + 2 < name.size() &&
                         std::isxdigit(static_cast<unsigned char>(name[i + 1])) &&
                         std::isxdigit(static_cast<unsigned char>(name[i + 2]));
      if (coded) code = static_cast<unsigned>(std::stoul(name.substr(i + 1, 2), nullptr, 16)), i += 2;
      plain += coded ? static_cast<char>(code) : name[i];
    }
    return plain;
  }

  std::size_t product(std::size_t a, std::size_t b) {
    if (b != 0 && a > file_.bytes().size() * 8 / b) file_.fail("an array is larger than the file");
    return a * b;
  }

  // ---- Arrays

  static std::string in_lower(std::string_view text) {
    std::string lower(text);
    for (char& c : lower) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return lower;
  }

  // The type, the rest of its line, the numbers.
  std::vector<double> read_array(std::size_t size, const char* what) {
    const std::string type = in_lower(file_.word("a type"));
    file_.line();
    return numbers(size, type, what);
  }

  std::vector<std::int64_t> read_whole_array(std::size_t size, const char* what) {
    const std::string type = in_lower(file_.word("a type"));
    file_.line();
    return whole_numbers(size, type, what);
  }

  std::vector<double> numbers(std::size_t size, const std::string& type, const char* what) {
    if (type == "string") return pass_texts(size);
    if (type == "bit" && binary_) {
      file_.take((size + 7) / 8, what);
      return {};
    }
    std::vector<double> values = reserved<double>(size);
    for (std::size_t i = 0; i < size; ++i) values.push_back(binary_ ? binary_number(type) : any_real(what));
    return values;
  }

  std::vector<std::int64_t> whole_numbers(std::size_t size, const std::string& type, const char* what) {
    std::vector<std::int64_t> values = reserved<std::int64_t>(size);
    for (std::size_t i = 0; i < size; ++i)
      values.push_back(binary_ ? static_cast<std::int64_t>(binary_number(type)) : file_.integer(what));
    return values;
  }

  // Room for no more numbers than the file can hold, whatever it announces.
  template <class Number>
  std::vector<Number> reserved(std::size_t size) const {
    std::vector<Number> values;
    values.reserve(std::min(size, file_.left()));
    return values;
  }

  // A result may be nan.
  double any_real(const char* what) {
    const std::string_view found = file_.word(what);
    const std::optional<double> value = parse_real(found);
    if (!value) file_.fail(std::string("expected a number of ") + what + ", found " + in_quotes(found));
    return *value;
  }

  double binary_number(const std::string& type) {
    const char* what = "an array";
    if (type == "double") return file_.binary<double>(what);
    if (type == "float") return file_.binary<float>(what);
    if (type == "int") return file_.binary<std::int32_t>(what);
    if (type == "unsigned_int") return file_.binary<std::uint32_t>(what);
    if (type == "vtkidtype") return file_.binary<std::int32_t>(what);
    if (type == "char" || type == "signed_char") return file_.binary<std::int8_t>(what);
    if (type == "unsigned_char") return file_.binary<std::uint8_t>(what);
    if (type == "short") return file_.binary<std::int16_t>(what);
    if (type == "unsigned_short") return file_.binary<std::uint16_t>(what);
    if (type == "long" || type == "vtktypeint64") return static_cast<double>(file_.binary<std::int64_t>(what));
    if (type == "unsigned_long" || type == "vtktypeuint64")
      return static_cast<double>(file_.binary<std::uint64_t>(what));
    file_.fail("expected a type of numbers, found " + in_quotes(type));
  }

  std::vector<double> pass_texts(std::size_t size) {
    for (std::size_t i = 0; i < size; ++i) binary_ ? pass_binary_text() : void(file_.line());
    return {};
  }

  // The first two bits tell how many bytes the length takes.
  void pass_binary_text() {
    const auto first = static_cast<unsigned char>(file_.take(1, "a text")[0]);
    std::uint64_t length = first & 0x3f;
    const std::size_t extra = (std::size_t{1} << (3 - (first >> 6))) - 1;
    for (const char byte : file_.take(extra, "a text")) length = length << 8 | static_cast<unsigned char>(byte);
    file_.take(length, "a text");
  }

  FileText file_;
  MeshContents contents_;
  VtkGrid grid_;
  bool binary_ = false, has_cells_ = false, of_cells_ = false;
  std::optional<std::size_t> tuples_;
};

}  // namespace

MeshContents read_vtk(std::string_view bytes) { return VtkReader(bytes).read(); }

}  // namespace acus
