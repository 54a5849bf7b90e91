// SPDX-License-Identifier: GPL-3.0-or-later
// Files of VTK's XML formats, version 1.0, as ParaView reads them: one piece, its arrays as raw bytes at the end.
// https://docs.vtk.org/en/latest/design_documents/VTKFileFormats.html
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace acus {

struct VtkArray {
  std::string name;
  const char* type;        // VTK's, "Float64"
  int components;          // of each of its values
  std::vector<char> bytes;
};

VtkArray vtk_array(std::string name, std::span<const double> numbers, int components = 1);
VtkArray vtk_array(std::string name, std::span<const std::int64_t> numbers);
VtkArray vtk_array(std::string name, std::span<const std::uint8_t> numbers);

struct VtkSection {
  std::string name;  // "Points", "Cells", "PointData", ...
  std::vector<VtkArray> arrays;
};

// Without cells of a kind there are none of it.
struct VtkPiece {
  const char* type;  // "UnstructuredGrid" or "PolyData"
  std::string counts;  // the piece's attributes, 'NumberOfPoints="4" NumberOfCells="1"'
  std::vector<VtkSection> sections;
};

// Throws std::runtime_error that names the file.
void write_vtk(const std::string& path, const VtkPiece& piece);

// A file for each moment: what ParaView opens as one animation.
struct VtkFrame {
  double time = 0;   // s
  std::string file;  // beside the collection
};
void write_vtk_collection(const std::string& path, std::span<const VtkFrame> frames);

}  // namespace acus
