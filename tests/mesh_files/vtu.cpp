// SPDX-License-Identifier: GPL-3.0-or-later
// Every form in which VTK's XML holds arrays: text, base64 or raw bytes, beside the elements or appended, compressed or
// not, either byte order, short and long headers.
#include <doctest/doctest.h>
#include <zlib.h>

#include "tests/mesh_files/read_text.h"

namespace acus {
namespace {

using test::error_of;
using test::find_group;
using test::read_text;

std::string base64(const std::string& bytes) {
  constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const auto at = [&](std::size_t k) { return i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u; };
    const unsigned group = at(0) << 16 | at(1) << 8 | at(2);
    for (std::size_t k = 0; k < 4; ++k) text += i + k > bytes.size() ? '=' : kDigits[group >> (18 - 6 * k) & 63];
  }
  return text;
}

struct Form {
  std::string mode;  // ascii, binary, raw, base64
  bool compressed, wide, big, together;
};

// Two tetrahedra in a form.
class Writer {
 public:
  explicit Writer(const Form& form) : form_(form) {}

  std::string text() {
    const std::string head =
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"" +
        std::string(form_.big ? "BigEndian" : "LittleEndian") + "\" header_type=\"" +
        (form_.wide ? "UInt64\"" : "UInt32\"") + (form_.compressed ? " compressor=\"vtkZLibDataCompressor\"" : "") +
        ">\n";
    std::string text = head + "<UnstructuredGrid><Piece NumberOfPoints=\"5\" NumberOfCells=\"2\">\n<Points>" +
                       array<double>("Float64", "Points", {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 1}) +
                       "</Points>\n<Cells>" + array<std::int64_t>("Int64", "connectivity", {0, 1, 2, 3, 4, 1, 2, 3}) +
                       array<std::int32_t>("Int32", "offsets", {4, 8}) +
                       array<std::uint8_t>("UInt8", "types", {10, 10}) + "</Cells>\n<CellData>" +
                       array<float>("Float32", "quality", {0.5f, 0.25f}) +
                       array<std::int16_t>("Int16", "region", {-3, 300}) + "</CellData>\n</Piece></UnstructuredGrid>\n";
    if (!appended_.empty())
      text += "<AppendedData encoding=\"" + form_.mode + "\">\n_" + appended_ + "\n</AppendedData>\n";
    return text + "</VTKFile>\n";
  }

 private:
  template <class Number>
  std::string bytes_of(const std::vector<Number>& numbers) const {
    std::string bytes;
    for (const Number number : numbers) {
      std::string one(sizeof(number), '\0');
      std::memcpy(one.data(), &number, sizeof(number));
      if (form_.big) std::reverse(one.begin(), one.end());
      bytes += one;
    }
    return bytes;
  }

  std::string header(const std::vector<std::uint64_t>& words) const {
    if (form_.wide) return bytes_of(words);
    return bytes_of(std::vector<std::uint32_t>(words.begin(), words.end()));
  }

  // In blocks of 16 bytes.
  std::string compressed(const std::string& bytes, std::string& head) const {
    constexpr std::size_t kBlock = 16;
    std::vector<std::uint64_t> words{(bytes.size() + kBlock - 1) / kBlock, kBlock, bytes.size() % kBlock};
    std::string blocks;
    for (std::size_t i = 0; i < bytes.size(); i += kBlock) {
      const std::string block = bytes.substr(i, kBlock);
      uLongf size = compressBound(block.size());
      std::string packed(size, '\0');
      compress(reinterpret_cast<Bytef*>(packed.data()), &size, reinterpret_cast<const Bytef*>(block.data()),
               block.size());
      words.push_back(size);
      blocks += packed.substr(0, size);
    }
    head = header(words);
    return blocks;
  }

  std::string encoded(const std::string& bytes) const {
    std::string head = header({bytes.size()}), body = bytes;
    if (form_.compressed) body = compressed(bytes, head);
    if (form_.mode == "raw") return head + body;
    return form_.together ? base64(head + body) : base64(head) + base64(body);
  }

  template <class Number>
  std::string array(const std::string& type, const std::string& name, const std::vector<Number>& numbers) {
    std::string open = "<DataArray type=\"" + type + "\" Name=\"" + name + "\" NumberOfComponents=\"" +
                       (name == "Points" ? "3" : "1") + "\" format=\"";
    if (form_.mode == "ascii") {
      for (std::string text = open + "ascii\">\n";;) {
        for (const Number number : numbers) text += std::to_string(number) + " ";
        return text + "</DataArray>\n";
      }
    }
    if (form_.mode == "binary") return open + "binary\">\n   " + encoded(bytes_of(numbers)) + "\n</DataArray>\n";
    const std::size_t offset = appended_.size();
    appended_ += encoded(bytes_of(numbers));
    return open + "appended\" offset=\"" + std::to_string(offset) + "\"/>\n";
  }

  Form form_;
  std::string appended_;
};

std::vector<Form> all_forms() {
  std::vector<Form> forms;
  for (const char* mode : {"ascii", "binary", "raw", "base64"})
    for (int bits = 0; bits < 16; ++bits)
      forms.push_back({mode, (bits & 1) != 0, (bits & 2) != 0, (bits & 4) != 0, (bits & 8) != 0});
  return forms;
}

}  // namespace

TEST_CASE("arrays are the same in all forms") {
  for (const Form& form : all_forms()) {
    CAPTURE(form.mode);
    CAPTURE(form.compressed);
    CAPTURE(form.wide);
    CAPTURE(form.big);
    CAPTURE(form.together);
    if (form.compressed && form.together && form.mode != "raw") continue;  // VTK encodes the two apart
    const RawMesh mesh = read_text(Writer(form).text());
    CHECK(mesh.coordinates == std::vector<double>{0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 1});
    CHECK(mesh.tetrahedra == std::vector<std::int32_t>{0, 1, 2, 3, 4, 1, 2, 3});
    REQUIRE(mesh.groups.size() == 2);
    CHECK(find_group(mesh, "region 300")->members == std::vector<int>{1});
    CHECK(find_group(mesh, "-3")->members == std::vector<int>{0});
  }
}

TEST_CASE("a file in any form that is cut off is refused") {
  for (const Form& form : all_forms()) {
    const std::string text = Writer(form).text();
    const std::size_t end = text.rfind(form.mode == "raw" || form.mode == "base64" ? "\n</AppendedData>" : "</Piece>");
    for (std::size_t size = 0; size < end; size += 7) {
      CAPTURE(form.mode);
      CAPTURE(size);
      CHECK(error_of(text.substr(0, size)) != "no error");
    }
  }
}

TEST_CASE("pieces are joined at the points they share, without their ghost cells") {
  const auto piece = [](const std::string& points, const std::string& ghost) {
    return "<Piece NumberOfPoints=\"4\" NumberOfCells=\"1\"><Points><DataArray type=\"Float32\" "
           "NumberOfComponents=\"3\" format=\"ascii\">" +
           points +
           "</DataArray></Points><Cells><DataArray type=\"Int32\" Name=\"connectivity\">0 1 2 3</DataArray>"
           "<DataArray type=\"Int32\" Name=\"offsets\">4</DataArray><DataArray type=\"UInt8\" "
           "Name=\"types\">10</DataArray></Cells>"
           "<CellData><DataArray type=\"UInt8\" Name=\"vtkGhostType\">" +
           ghost + "</DataArray></CellData></Piece>";
  };
  const std::string first = "0 0 0 1 0 0 0 1 0 0 0 1", second = "1 1 1 1 0 0 0 1 0 0 0 1";
  const RawMesh mesh =
      read_text("<VTKFile type=\"UnstructuredGrid\" byte_order=\"LittleEndian\"><UnstructuredGrid>" +
                piece(first, "0") + piece(first, "1") + piece(second, "0") + "</UnstructuredGrid></VTKFile>");
  CHECK(mesh.coordinates.size() == 15);
  CHECK(mesh.tetrahedra == std::vector<std::int32_t>{0, 1, 2, 3, 4, 1, 2, 3});
}

TEST_CASE("damaged files of VTK's XML are refused with the array's name") {
  const std::string text = Writer({"ascii", false, false, false, false}).text();
  const auto changed = [&text](const std::string& from, const std::string& to) {
    std::string other = text;
    other.replace(other.find(from), from.size(), to);
    return error_of(other);
  };
  CHECK(changed("NumberOfCells=\"2\"", "NumberOfCells=\"3\"") == "array \"offsets\" has 2 numbers, expected 3");
  CHECK(changed("4 8", "4 9") == "cell 1 ends at entry 9 of a connectivity of 8");
  CHECK(changed("4 8", "4 7") == "cell 1, of VTK's type 10, has 3 points, expected 4");
  CHECK(changed("10 10", "10 nan") == "array \"types\" has numbers that are not whole");
  CHECK(changed("</Cells>", "</Cell>").starts_with("line "));
  std::string packed = Writer({"binary", true, false, false, false}).text();
  packed.replace(packed.find("vtkZLib"), 7, "vtkLZMA");
  CHECK(error_of(packed) == "the file is compressed with vtkLZMADataCompressor; save it with zlib, or not compressed");
}

}  // namespace acus
