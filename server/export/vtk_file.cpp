// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/export/vtk_file.h"

#include <bit>
#include <fstream>
#include <stdexcept>

namespace acus {

namespace {

static_assert(std::endian::native == std::endian::little, "the files say that they are little-endian");

using Size = std::uint64_t;  // before the bytes of an array

template <class Number>
VtkArray array_of(std::string name, const char* type, std::span<const Number> numbers, int components) {
  const auto bytes = std::as_bytes(numbers);
  const auto* first = reinterpret_cast<const char*>(bytes.data());
  return {std::move(name), type, components, {first, first + bytes.size()}};
}

std::ofstream open(const std::string& path) {
  std::ofstream file(path, std::ios::binary);
  if (!file) throw std::runtime_error(path + ": the file cannot be written");
  return file;
}

void close(std::ofstream& file, const std::string& path) {
  file.close();
  if (!file) throw std::runtime_error(path + ": the file cannot be written; is the disk full?");
}

std::string file_tag(const char* type) {
  return "<?xml version=\"1.0\"?>\n<VTKFile type=\"" + std::string(type) +
         "\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n";
}

}  // namespace

VtkArray vtk_array(std::string name, std::span<const double> numbers, int components) {
  return array_of(std::move(name), "Float64", numbers, components);
}
VtkArray vtk_array(std::string name, std::span<const std::int64_t> numbers) {
  return array_of(std::move(name), "Int64", numbers, 1);
}
VtkArray vtk_array(std::string name, std::span<const std::uint8_t> numbers) {
  return array_of(std::move(name), "UInt8", numbers, 1);
}

void write_vtk(const std::string& path, const VtkPiece& piece) {
  std::ofstream file = open(path);
  file << file_tag(piece.type) << "<" << piece.type << ">\n<Piece " << piece.counts << ">\n";
  Size offset = 0;
  for (const VtkSection& section : piece.sections) {
    file << "<" << section.name << ">\n";
    for (const VtkArray& array : section.arrays) {
      file << "<DataArray type=\"" << array.type << "\" Name=\"" << array.name << "\" NumberOfComponents=\""
           << array.components << "\" format=\"appended\" offset=\"" << offset << "\"/>\n";
      offset += sizeof(Size) + array.bytes.size();
    }
    file << "</" << section.name << ">\n";
  }
  file << "</Piece>\n</" << piece.type << ">\n<AppendedData encoding=\"raw\">\n_";
  for (const VtkSection& section : piece.sections) {
    for (const VtkArray& array : section.arrays) {
      const Size size = array.bytes.size();
      file.write(reinterpret_cast<const char*>(&size), sizeof size);
      file.write(array.bytes.data(), static_cast<std::streamsize>(size));
    }
  }
  file << "\n</AppendedData>\n</VTKFile>\n";
  close(file, path);
}

void write_vtk_collection(const std::string& path, std::span<const VtkFrame> frames) {
  std::ofstream file = open(path);
  file.precision(15);
  file << file_tag("Collection") << "<Collection>\n";
  for (const VtkFrame& frame : frames)
    file << "<DataSet timestep=\"" << frame.time << "\" part=\"0\" file=\"" << frame.file << "\"/>\n";
  file << "</Collection>\n</VTKFile>\n";
  close(file, path);
}

}  // namespace acus
