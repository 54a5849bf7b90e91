// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/mesh_files/file_format.h"

#include <algorithm>
#include <cctype>

#include "server/engine/mesh_files/formats/readers.h"
#include "server/engine/mesh_files/tetrahedra.h"
#include "server/engine/models/geometry/tetrahedral_mesh.h"

namespace acus {
namespace {

constexpr const char* kFill = "fill it with tetrahedra, for instance with Gmsh (gmsh -3) or TetGen, and save those";
constexpr const char* kConvert =
    "save it as .vtu, .msh, .mesh, .inp, .bdf or .unv with the program that made it, or convert it with meshio";

// The beginning of a file that is no volume mesh of ours, what it is, and what to do.
struct Opening {
  std::string_view begins;
  const char* what;
  const char* remedy;
};

constexpr std::array<Opening, 27> kOthers{{
    {"version https://git-lfs", "the pointer of a file that Git LFS keeps", "fetch it with `git lfs pull`"},
    {"\x1f\x8b", "a file compressed with gzip", "unpack it with gunzip"},
    {"PK\x03\x04", "a zip file", "unpack it"},
    {"\xff\xfe", "text in UTF-16", "save it as UTF-8"},
    {"\xfe\xff", "text in UTF-16", "save it as UTF-8"},
    {"\x89HDF", "an HDF5 file (MED, XDMF or the like)", kConvert},
    {"CDF\x01", "a netCDF file (Exodus)", kConvert},
    {"CDF\x02", "a netCDF file (Exodus)", kConvert},
    {"ply\n", "a surface (PLY)", kFill},
    {"ply\r", "a surface (PLY)", kFill},
    {"OFF", "a surface (OFF)", kFill},
    {"solid", "a surface (STL)", kFill},
    {"ISO-10303-21", "a CAD model (STEP)", "mesh it with tetrahedra, for instance with Gmsh (gmsh -3)"},
    {"DBRep_DrawableShape", "a CAD model (BREP)", "mesh it with tetrahedra, for instance with Gmsh (gmsh -3)"},
    {"NRRD", "an image (NRRD)", "segment it and mesh the regions with tetrahedra"},
    {"mesh3d", "a mesh of Netgen", kConvert},
    {"(0 ", "a mesh of Ansys Fluent", kConvert},
    {"(1 ", "a mesh of Ansys Fluent", kConvert},
    {"NDIME", "a mesh of SU2", kConvert},
    {"MFEM ", "a mesh of MFEM", kConvert},
    {"TITLE", "a file of Tecplot", kConvert},
    {"# Created by COMSOL", "a mesh of COMSOL", kConvert},
    {"<Xdmf", "an XDMF file", kConvert},
    {"<dolfin", "a mesh of DOLFIN", kConvert},
    {"<?xml", "XML that is no file of VTK", kConvert},
    {"Merge ", "a script of Gmsh", "make the mesh with `gmsh -3` and name its .msh file"},
    {"SetFactory", "a script of Gmsh", "make the mesh with `gmsh -3` and name its .msh file"},
}};

[[noreturn]] void refuse(const std::string& what, const std::string& remedy) {
  throw MeshError("expected a volume mesh, found " + what + "; " + remedy);
}

// 80 bytes, a number of triangles, 50 bytes each.
bool is_binary_stl(std::string_view bytes) {
  if (bytes.size() < 84) return false;
  return bytes.size() == 84 + std::size_t{50} * FileText::number_at<std::uint32_t>(&bytes[80], false);
}

// Whether some line of the first thousand begins with a word that passes.
template <class Test>
bool some_line(std::string_view bytes, Test test) {
  FileText file(bytes);
  for (int i = 0; i < 1000 && file.left() > 0; ++i)
    if (test(trimmed(file.line()))) return true;
  return false;
}

bool is_obj(std::string_view bytes) {
  return some_line(bytes, [](std::string_view line) { return line.starts_with("v ") || line.starts_with("vn "); });
}

bool is_nastran(std::string_view bytes) {
  return some_line(bytes, [](std::string_view line) {
    const std::string word = in_capitals(line.substr(0, line.find_first_of(" ,*\t")));
    return word == "GRID" || word == "CTETRA" || word == "CHEXA" || word == "CPENTA" || word == "CEND" ||
           (word == "BEGIN" && in_capitals(line).find("BULK") != std::string::npos);
  });
}

bool is_abaqus(std::string_view bytes) {
  bool keyword = false;
  some_line(bytes, [&keyword](std::string_view line) {
    if (line.empty() || line.starts_with("**")) return false;
    keyword = line[0] == '*' && line.size() > 1 && std::isalpha(static_cast<unsigned char>(line[1])) != 0;
    return true;
  });
  return keyword;
}

bool is_binary_medit(std::string_view bytes) {
  if (bytes.size() < 8) return false;
  for (const bool swapped : {false, true}) {
    const auto one = FileText::number_at<std::int32_t>(&bytes[0], swapped);
    const auto version = FileText::number_at<std::int32_t>(&bytes[4], swapped);
    if (one == 1 && version >= 1 && version <= 4) return true;
  }
  return false;
}

bool ends_with(const std::string& name, std::string_view ending) { return in_capitals(name).ends_with(ending); }

bool is_vtu(std::string_view bytes) {
  return bytes.starts_with("<") && bytes.substr(0, 4096).find("<VTKFile") != std::string_view::npos;
}

// TetGen's files: `ele` lists the tetrahedra.
RawMesh read_pair(std::string_view ele, std::string_view node) {
  if (ele.empty() || node.empty())
    throw MeshError(std::string("a mesh of TetGen is two files of one name, .ele and .node; the ") +
                    (ele.empty() ? ".ele" : ".node") + " file is not beside the other one");
  return make_tetrahedra(FileText(ele), read_tetgen(ele, node));
}

void refuse_other_formats(std::string_view bytes) {
  std::string_view text = bytes;  // its first line that is no comment
  some_line(bytes, [&text](std::string_view line) {
    text = line;
    return !line.empty() && line[0] != '#';
  });
  for (const Opening& other : kOthers)
    if (bytes.starts_with(other.begins) || text.starts_with(other.begins)) refuse(other.what, other.remedy);
  if (bytes.size() > 348 && (bytes.substr(344, 2) == "n+" || bytes.substr(344, 2) == "ni"))
    refuse("an image (NIfTI)", "segment it and mesh the regions with tetrahedra");
  if (bytes.size() > 132 && bytes.substr(128, 4) == "DICM")
    refuse("an image (DICOM)", "segment it and mesh the regions with tetrahedra");
  if (is_binary_stl(bytes)) refuse("a surface (STL)", kFill);
  if (is_obj(bytes)) refuse("a surface (OBJ)", kFill);
}

MeshContents read_contents(std::string_view bytes, std::string_view first_words) {
  for (const std::string_view msh : {"$MeshFormat", "$NOD", "$Comments", "$PhysicalNames"})
    if (first_words.starts_with(msh)) return read_msh(bytes);
  if (first_words.starts_with("# vtk DataFile")) return read_vtk(bytes);
  if (is_vtu(first_words)) return read_vtu(bytes);
  if (first_words.starts_with("MeshVersionFormatted") || is_binary_medit(bytes)) return read_medit(bytes);
  refuse_other_formats(bytes);
  if (trimmed(first_words.substr(0, first_words.find('\n'))) == "-1") return read_unv(bytes);
  if (is_abaqus(bytes)) return read_abaqus(bytes);
  if (is_nastran(bytes)) return read_nastran(bytes);
  refuse("a file of a format that is not read", kConvert);
}

}  // namespace

RawMesh read_mesh_bytes(std::string_view bytes, const std::string& name, std::string_view companion) {
  if (bytes.starts_with("\xef\xbb\xbf")) bytes.remove_prefix(3);  // the byte-order mark of UTF-8
  const std::string_view first_words = bytes.substr(std::min(bytes.find_first_not_of(kSpaces), bytes.size()));
  if (first_words.empty()) refuse("an empty file", "save it again");
  const char first = first_words[0];
  if (ends_with(name, ".ELE") && (std::isdigit(static_cast<unsigned char>(first)) != 0 || first == '#'))
    return read_pair(bytes, companion);
  if (ends_with(name, ".NODE") && (std::isdigit(static_cast<unsigned char>(first)) != 0 || first == '#'))
    return read_pair(companion, bytes);
  return make_tetrahedra(FileText(bytes), read_contents(bytes, first_words));
}

}  // namespace acus
