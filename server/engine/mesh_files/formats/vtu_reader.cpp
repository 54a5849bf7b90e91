// SPDX-License-Identifier: GPL-3.0-or-later
// VTK's XML format: https://docs.vtk.org, "VTK file formats". An array's bytes follow a header: their number, or, where
// they are compressed, the number of blocks, the size of a block and of the last one if it is smaller, and the
// compressed size of each.
#include <zlib.h>

#include <pugixml.hpp>

#include "server/engine/mesh_files/formats/readers.h"
#include "server/engine/mesh_files/formats/vtk_cells.h"
#include "server/engine/models/geometry/tetrahedral_mesh.h"

namespace acus {
namespace {

// Bytes of base64, at most `most`. Padding may stand in the middle: header and data are encoded one after the other.
std::string decode_base64(std::string_view text, std::size_t most) {
  constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  std::uint32_t group = 0;
  int digits = 0, padding = 0;
  for (const char c : text) {
    if (bytes.size() >= most) break;
    const std::size_t digit = kDigits.find(c);
    if (digit == std::string_view::npos && c != '=') {
      if (kSpaces.find(c) != std::string_view::npos) continue;
      break;
    }
    padding += c == '=';
    group = group << 6 | static_cast<std::uint32_t>(c == '=' ? 0 : digit);
    if (++digits < 4) continue;
    for (int i = 0; i < 3 - padding; ++i) bytes += static_cast<char>(group >> (16 - 8 * i) & 0xff);
    group = 0, digits = 0, padding = 0;
  }
  bytes.resize(std::min(bytes.size(), most));
  return bytes;
}

class VtuReader {
 public:
  explicit VtuReader(std::string_view bytes) : bytes_(bytes) {}

  MeshContents read() {
    const pugi::xml_node file = parse();
    const std::string type = file.attribute("type").value();
    if (type == "PolyData")
      throw MeshError(
          "expected an unstructured grid, found a surface (PolyData); fill it with tetrahedra, for instance with Gmsh "
          "or TetGen");
    if (type != "UnstructuredGrid")
      throw MeshError("expected a VTK file of type UnstructuredGrid, found " + in_quotes(type) +
                      "; in ParaView, save the data as .vtu");
    contents_.format = std::string("VTK XML ") + file.attribute("version").value();
    wide_header_ = std::string_view(file.attribute("header_type").value()) == "UInt64";
    swapped_ = (std::string_view(file.attribute("byte_order").value()) == "BigEndian") ==
               (std::endian::native == std::endian::little);
    read_compressor(file.attribute("compressor").value());
    std::size_t pieces = 0;
    for (const pugi::xml_node piece : file.child("UnstructuredGrid").children("Piece")) read_piece(piece), ++pieces;
    if (pieces > 1) join_equal_points();
    add_cell_groups(arrays_, element_of_cell_, contents_);
    return std::move(contents_);
  }

 private:
  // Appended data are no XML: they are cut out before it is parsed.
  pugi::xml_node parse() {
    std::string xml(bytes_);
    const std::size_t tag = bytes_.find("<AppendedData");
    if (tag != std::string_view::npos) {
      const std::size_t tag_end = bytes_.find('>', tag);
      const std::size_t begin = bytes_.find('_', tag_end);
      if (begin == std::string_view::npos) throw MeshError("AppendedData holds no '_', after which its bytes stand");
      appended_ = bytes_.substr(begin + 1);
      appended_in_base64_ = bytes_.substr(tag, tag_end - tag).find("base64") != std::string_view::npos;
      xml = xml.substr(0, tag) + "</VTKFile>";
    }
    const pugi::xml_parse_result parsed = document_.load_buffer(xml.data(), xml.size());
    if (!parsed)
      FileText(bytes_).fail_at(static_cast<std::size_t>(parsed.offset), std::string("no XML: ") + parsed.description());
    return document_.child("VTKFile");
  }

  void read_compressor(const std::string& name) {
    if (name.empty()) return;
    compressed_ = true;
    if (name == "vtkZLibDataCompressor") return;
    throw MeshError("the file is compressed with " + name + "; save it with zlib, or not compressed");
  }

  void read_piece(const pugi::xml_node& piece) {
    const std::size_t points = number(piece, "NumberOfPoints"), cells = number(piece, "NumberOfCells");
    VtkGrid grid;
    const pugi::xml_node places = piece.child("Points").child("DataArray");
    grid.points = values(places, "Points");
    expect_size(grid.points.size(), 3 * points, "Points");
    grid.connectivity = whole_values(array_named(piece.child("Cells"), "connectivity"));
    grid.offsets = whole_values(array_named(piece.child("Cells"), "offsets"));
    grid.types = whole_values(array_named(piece.child("Cells"), "types"));
    expect_size(grid.offsets.size(), cells, "offsets");
    expect_size(grid.types.size(), cells, "types");
    read_cell_data(piece.child("CellData"), cells, grid.cell_arrays);
    const std::vector<int> elements = add_grid(grid, contents_);
    element_of_cell_.insert(element_of_cell_.end(), elements.begin(), elements.end());
    for (const VtkCellArray& array : grid.cell_arrays) append(array);
  }

  void read_cell_data(const pugi::xml_node& data, std::size_t cells, std::vector<VtkCellArray>& arrays) {
    for (const pugi::xml_node array : data.children("DataArray")) {
      const bool of_bits = std::string_view(array.attribute("type").value()) == "Bit";
      if (of_bits || array.attribute("NumberOfComponents").as_uint(1) > 1) continue;
      const std::string name = array.attribute("Name").value();
      std::optional<std::vector<std::int64_t>> whole = as_whole_numbers(values(array, name));
      if (whole && whole->size() == cells) arrays.push_back({name, std::move(*whole)});
    }
  }

  // An array that a piece lacks has fewer values than there are cells in all, and becomes no groups.
  void append(const VtkCellArray& array) {
    const auto same = [&array](const VtkCellArray& known) { return known.name == array.name; };
    auto known = std::find_if(arrays_.begin(), arrays_.end(), same);
    if (known == arrays_.end()) known = arrays_.insert(known, {array.name, {}});
    known->values.insert(known->values.end(), array.values.begin(), array.values.end());
  }

  // Each piece has points of its own, equal to the last bit where pieces meet.
  void join_equal_points() {
    std::map<std::array<double, 3>, std::int64_t> first;
    for (const MeshNode& node : contents_.nodes) first.try_emplace(node.x, node.number);
    for (MeshElement& element : contents_.elements)
      for (std::int64_t& node : element.used_nodes())
        node = first.at(contents_.nodes[static_cast<std::size_t>(node)].x);
  }

  static std::size_t number(const pugi::xml_node& piece, const char* attribute) {
    const std::optional<std::int64_t> value = parse_integer(trimmed(piece.attribute(attribute).value()));
    if (!value || *value < 0)
      throw MeshError(std::string("expected ") + attribute + " of a Piece, found " +
                      in_quotes(piece.attribute(attribute).value()));
    return static_cast<std::size_t>(*value);
  }

  static pugi::xml_node array_named(const pugi::xml_node& parent, const char* name) {
    const pugi::xml_node found = parent.find_child_by_attribute("DataArray", "Name", name);
    if (!found) throw MeshError(std::string("expected an array ") + name + " in Cells, found none");
    return found;
  }

  static void expect_size(std::size_t found, std::size_t expected, const std::string& name) {
    if (found == expected) return;
    throw MeshError("array " + in_quotes(name) + " has " + std::to_string(found) + " numbers, expected " +
                    std::to_string(expected));
  }

  // ---- Arrays

  std::vector<double> values(const pugi::xml_node& array, const std::string& name) {
    if (format_of(array) == "ascii") return text_values(array.text().get());
    return convert<double>(bytes_of(array, name), array.attribute("type").value(), name);
  }

  std::vector<std::int64_t> whole_values(const pugi::xml_node& array) {
    const std::string name = array.attribute("Name").value();
    if (format_of(array) != "ascii")
      return convert<std::int64_t>(bytes_of(array, name), array.attribute("type").value(), name);
    std::optional whole = as_whole_numbers(text_values(array.text().get()));
    if (!whole) throw MeshError("array " + in_quotes(name) + " has numbers that are not whole");
    return std::move(*whole);
  }

  static std::string_view format_of(const pugi::xml_node& array) {
    return array.attribute("format").as_string("ascii");
  }

  static std::vector<double> text_values(std::string_view text) {
    FileText words(text);
    std::vector<double> result;
    while (!words.peek().empty()) {
      const std::string_view word = words.word("a number");
      const std::optional<double> value = parse_real(word);
      if (!value) throw MeshError("expected a number in an array, found " + in_quotes(word));
      result.push_back(*value);
    }
    return result;
  }

  std::string bytes_of(const pugi::xml_node& array, const std::string& name) {
    const std::string_view format = format_of(array);
    if (format == "binary") return unpacked(array.text().get(), true, name);
    if (format != "appended")
      throw MeshError("array " + in_quotes(name) + " is of format " + in_quotes(format) +
                      ", expected ascii, binary or appended");
    const std::uint64_t offset = array.attribute("offset").as_ullong();
    if (offset > appended_.size())
      throw MeshError("array " + in_quotes(name) + " begins after the end of the file; it is cut off");
    return unpacked(appended_.substr(offset), appended_in_base64_, name);
  }

  // `encoded` begins with the array's header, and may go on behind its bytes.
  std::string unpacked(std::string_view encoded, bool base64, const std::string& name) {
    const std::size_t word = wide_header_ ? 8 : 4;
    const auto raw = [&](std::size_t size) {
      std::string bytes = base64 ? decode_base64(encoded, size) : std::string(encoded.substr(0, size));
      if (bytes.size() < size) throw MeshError("array " + in_quotes(name) + " is cut off");
      return bytes;
    };
    const std::string first = raw(word);
    if (!compressed_) {
      const std::uint64_t size = header_word(first, 0);
      check_fits(size, encoded.size(), name);
      return raw(word + size).substr(word);
    }
    const std::uint64_t blocks = header_word(first, 0);
    if (blocks == 0) return "";
    check_fits(blocks, encoded.size(), name);
    const std::string header = raw((3 + blocks) * word);
    std::uint64_t compressed = 0;
    for (std::uint64_t i = 0; i < blocks; ++i) {
      const std::uint64_t size = header_word(header, 3 + i);
      check_fits(size, encoded.size(), name);
      compressed += size;
    }
    check_fits(compressed, encoded.size(), name);
    return inflated(header, raw(header.size() + compressed), blocks, name);
  }

  static void check_fits(std::uint64_t size, std::size_t left, const std::string& name) {
    if (size > left) throw MeshError("array " + in_quotes(name) + " is cut off, or its header is damaged");
  }

  std::uint64_t header_word(const std::string& bytes, std::size_t i) const {
    return wide_header_ ? FileText::number_at<std::uint64_t>(&bytes[8 * i], swapped_)
                        : FileText::number_at<std::uint32_t>(&bytes[4 * i], swapped_);
  }

  // `bytes` are header and blocks.
  std::string inflated(const std::string& header, const std::string& bytes, std::uint64_t blocks,
                       const std::string& name) const {
    constexpr std::uint64_t kMostOfBlock = std::uint64_t{1} << 30;
    const std::uint64_t size = header_word(header, 1), last = header_word(header, 2);
    if (size > kMostOfBlock || last > size) throw MeshError("array " + in_quotes(name) + " has a damaged header");
    std::string result;
    std::size_t at = header.size();
    for (std::uint64_t i = 0; i < blocks; ++i) {
      const auto compressed = static_cast<uLong>(header_word(header, 3 + i));
      const std::uint64_t expected = i + 1 == blocks && last > 0 ? last : size;
      const std::size_t begin = result.size();
      result.resize(begin + expected);
      uLongf found = expected;
      const auto* from = reinterpret_cast<const Bytef*>(&bytes[at]);
      if (uncompress(reinterpret_cast<Bytef*>(&result[begin]), &found, from, compressed) != Z_OK || found != expected)
        throw MeshError("array " + in_quotes(name) + " cannot be decompressed");
      at += compressed;
    }
    return result;
  }

  template <class Result, class Number>
  std::vector<Result> convert_from(const std::string& bytes) const {
    std::vector<Result> result(bytes.size() / sizeof(Number));
    for (std::size_t i = 0; i < result.size(); ++i)
      result[i] = static_cast<Result>(FileText::number_at<Number>(&bytes[i * sizeof(Number)], swapped_));
    return result;
  }

  template <class Result>
  std::vector<Result> convert(const std::string& bytes, const std::string& type, const std::string& name) const {
    if (type == "Float64") return convert_from<Result, double>(bytes);
    if (type == "Float32") return convert_from<Result, float>(bytes);
    if (type == "Int64") return convert_from<Result, std::int64_t>(bytes);
    if (type == "UInt64") return convert_from<Result, std::uint64_t>(bytes);
    if (type == "Int32") return convert_from<Result, std::int32_t>(bytes);
    if (type == "UInt32") return convert_from<Result, std::uint32_t>(bytes);
    if (type == "Int16") return convert_from<Result, std::int16_t>(bytes);
    if (type == "UInt16") return convert_from<Result, std::uint16_t>(bytes);
    if (type == "Int8") return convert_from<Result, std::int8_t>(bytes);
    if (type == "UInt8") return convert_from<Result, std::uint8_t>(bytes);
    throw MeshError("array " + in_quotes(name) + " is of type " + in_quotes(type) +
                    ", expected Float32, Int64 or the like");
  }

  std::string_view bytes_, appended_;
  pugi::xml_document document_;
  bool appended_in_base64_ = false, wide_header_ = false, swapped_ = false, compressed_ = false;
  MeshContents contents_;
  std::vector<VtkCellArray> arrays_;
  std::vector<int> element_of_cell_;
};

}  // namespace

MeshContents read_vtu(std::string_view bytes) { return VtuReader(bytes).read(); }

}  // namespace acus
