// SPDX-License-Identifier: GPL-3.0-or-later
// One tetrahedron in each format that meshes are read from.
#pragma once

#include <cstdint>
#include <cstring>
#include <initializer_list>
#include <string>
#include <vector>

namespace acus::test {

template <class Number>
std::string bytes_of(std::initializer_list<Number> numbers, bool big_endian = false) {
  std::string bytes;
  for (const Number number : numbers) {
    std::string one(sizeof(number), '\0');
    std::memcpy(one.data(), &number, sizeof(number));
    bytes.append(big_endian ? std::string(one.rbegin(), one.rend()) : one);
  }
  return bytes;
}

struct MeshFile {
  std::string name;
  std::string text;
};

// The unit tetrahedron as each format has it.
inline const MeshFile kMsh1{
    "a.msh", "$NOD\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n$ENDNOD\n$ELM\n1\n1 4 7 1 4 1 2 3 4\n$ENDELM\n"};
inline const MeshFile kMsh2{
    "b.msh",
    "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n3 7 \"liver\"\n$EndPhysicalNames\n"
    "$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n$EndNodes\n"
    "$Elements\n1\n1 4 2 7 1 1 2 3 4\n$EndElements\n"};
inline const MeshFile kMsh2Binary{"c.msh", "$MeshFormat\n2.2 1 8\n" + bytes_of({1}) + "\n$EndMeshFormat\n$Nodes\n4\n" +
                                               bytes_of({1}) + bytes_of({0., 0., 0.}) + bytes_of({2}) +
                                               bytes_of({1., 0., 0.}) + bytes_of({3}) + bytes_of({0., 1., 0.}) +
                                               bytes_of({4}) + bytes_of({0., 0., 1.}) + "\n$EndNodes\n$Elements\n1\n" +
                                               bytes_of({4, 1, 2, 1, 7, 1, 1, 2, 3, 4}) + "\n$EndElements\n"};
inline const MeshFile kMsh4{
    "d.msh",
    "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n3 7 \"liver\"\n$EndPhysicalNames\n"
    "$Entities\n0 0 0 1\n1 0 0 0 1 1 1 1 7 0\n$EndEntities\n$Nodes\n1 4 1 4\n3 1 0 4\n1\n2\n3\n4\n"
    "0 0 0\n1 0 0\n0 1 0\n0 0 1\n$EndNodes\n$Elements\n1 1 1 1\n3 1 4 1\n1 1 2 3 4\n$EndElements\n"};
inline const MeshFile kMsh4Binary{
    "e.msh", "$MeshFormat\n4.1 1 8\n" + bytes_of({1}) + "\n$EndMeshFormat\n$Entities\n" +
                 bytes_of<std::uint64_t>({0, 0, 0, 1}) + bytes_of({1}) + bytes_of({0., 0., 0., 1., 1., 1.}) +
                 bytes_of<std::uint64_t>({1}) + bytes_of({7}) + bytes_of<std::uint64_t>({0}) +
                 "\n$EndEntities\n$Nodes\n" + bytes_of<std::uint64_t>({1, 4, 1, 4}) + bytes_of({3, 1, 0}) +
                 bytes_of<std::uint64_t>({4, 1, 2, 3, 4}) + bytes_of({0., 0., 0., 1., 0., 0., 0., 1., 0., 0., 0., 1.}) +
                 "\n$EndNodes\n$Elements\n" + bytes_of<std::uint64_t>({1, 1, 1, 1}) + bytes_of({3, 1, 4}) +
                 bytes_of<std::uint64_t>({1, 1, 1, 2, 3, 4}) + "\n$EndElements\n"};
inline const MeshFile kVtk{"f.vtk",
                           "# vtk DataFile Version 2.0\nx\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 double\n"
                           "0 0 0\n1 0 0\n0 1 0\n0 0 1\n\nCELLS 1 5\n4 0 1 2 3\n\nCELL_TYPES 1\n10\n"};
inline const MeshFile kVtkBinary{
    "g.vtk", "# vtk DataFile Version 2.0\nx\nBINARY\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 double\n" +
                 bytes_of({0., 0., 0., 1., 0., 0., 0., 1., 0., 0., 0., 1.}, true) + "\n\nCELLS 1 5\n" +
                 bytes_of({4, 0, 1, 2, 3}, true) + "\n\nCELL_TYPES 1\n" + bytes_of({10}, true) + "\n"};
inline const MeshFile kUnv{"h.unv",
                           "    -1\n  2411\n"
                           "         1         1         1        11\n   0.0D+00   0.0D+00   0.0D+00\n"
                           "         2         1         1        11\n   1.0D+00   0.0D+00   0.0D+00\n"
                           "         3         1         1        11\n   0.0D+00   1.0D+00   0.0D+00\n"
                           "         4         1         1        11\n   0.0D+00   0.0D+00   1.0D+00\n    -1\n"
                           "    -1\n  2412\n         1       111         1         7         7         4\n"
                           "         1         2         3         4\n    -1\n"};
inline const MeshFile kMedit{"i.mesh",
                             "MeshVersionFormatted 2\nDimension 3\nVertices\n4\n0 0 0 1\n1 0 0 1\n0 1 0 1\n0 0 1 1\n"
                             "Tetrahedra\n1\n1 2 3 4 7\nEnd\n"};
inline const MeshFile kNastran{"j.bdf",
                               "BEGIN BULK\nGRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nGRID,3,,0.,1.,0.\nGRID,4,,0.,0.,1.\n"
                               "CTETRA,1,7,1,2,3,4\nENDDATA\n"};
inline const MeshFile kMeditBinary{
    "k.meshb", bytes_of({1, 2, 3, 20, 3, 4}) + bytes_of({20 + 12 + 4 * 28}) + bytes_of({4}) + bytes_of({0., 0., 0.}) +
                   bytes_of({1}) + bytes_of({1., 0., 0.}) + bytes_of({1}) + bytes_of({0., 1., 0.}) + bytes_of({1}) +
                   bytes_of({0., 0., 1.}) + bytes_of({1}) + bytes_of({8, 144 + 12 + 20, 1, 1, 2, 3, 4, 7, 54, 0})};
inline const MeshFile kVtk5{
    "l.vtk",
    "# vtk DataFile Version 5.1\nx\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 double\n"
    "0 0 0 1 0 0 0 1 0\n0 0 1\nMETADATA\nINFORMATION 1\nNAME L2_NORM_RANGE LOCATION vtkDataArray\n"
    "DATA 2 0 1\n\nCELLS 2 4\nOFFSETS vtktypeint64\n0 4\nCONNECTIVITY vtktypeint64\n0 1 2 3\n\n"
    "CELL_TYPES 1\n10\n\nCELL_DATA 1\nSCALARS region int 1\nLOOKUP_TABLE default\n7\n"
    "METADATA\nINFORMATION 0\n\n"};
inline const MeshFile kVtu{
    "m.vtu",
    "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"0.1\" byte_order=\"LittleEndian\">\n"
    "<UnstructuredGrid><Piece NumberOfPoints=\"4\" NumberOfCells=\"1\">\n"
    "<Points><DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">0 0 0 1 0 0 0 1 0 0 0 1</DataArray>"
    "</Points>\n<Cells><DataArray type=\"Int32\" Name=\"connectivity\" format=\"ascii\">0 1 2 3</DataArray>\n"
    "<DataArray type=\"Int32\" Name=\"offsets\" format=\"ascii\">4</DataArray>\n"
    "<DataArray type=\"UInt8\" Name=\"types\" format=\"ascii\">10</DataArray></Cells>\n"
    "<CellData><DataArray type=\"Int32\" Name=\"region\" format=\"ascii\">7</DataArray></CellData>\n"
    "</Piece></UnstructuredGrid></VTKFile>\n"};
// Its arrays as raw bytes behind the XML.
inline const MeshFile kVtuAppended{
    "n.vtu",
    "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"0.1\" byte_order=\"LittleEndian\">\n"
    "<UnstructuredGrid><Piece NumberOfPoints=\"4\" NumberOfCells=\"1\">\n"
    "<Points><DataArray type=\"Float32\" NumberOfComponents=\"3\" format=\"appended\" offset=\"0\"/></Points>\n"
    "<Cells><DataArray type=\"Int32\" Name=\"connectivity\" format=\"appended\" offset=\"52\"/>\n"
    "<DataArray type=\"Int32\" Name=\"offsets\" format=\"appended\" offset=\"72\"/>\n"
    "<DataArray type=\"UInt8\" Name=\"types\" format=\"appended\" offset=\"80\"/></Cells>\n"
    "</Piece></UnstructuredGrid>\n<AppendedData encoding=\"raw\">\n   _" +
        bytes_of({48}) + bytes_of<float>({0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1}) + bytes_of({16, 0, 1, 2, 3, 4, 4, 1}) +
        "\x0a\n</AppendedData>\n</VTKFile>\n"};
inline const MeshFile kAbaqus{"o.inp",
                              "** a comment\n*HEADING\nliver\n*Node\n1, 0., 0., 0.\n2, 1., 0., 0.\n3, 0., 1., 0.\n"
                              "4, 0., 0., 1.\n*Element, type=C3D4, elset=liver\n1, 1, 2, 3, 4\n*MATERIAL, NAME=soft\n"};
inline const MeshFile kTetgenNodes{"p.node", "# made by TetGen\n4 3 0 0\n0 0 0 0\n1 1 0 0\n2 0 1 0\n3 0 0 1\n"};
inline const MeshFile kTetgenElements{"p.ele", "1 4 1\n0 0 1 2 3 7\n"};
// All but TetGen's, which are two each.
inline const std::vector<MeshFile> kMeshFiles{kMsh1,        kMsh2,      kMsh2Binary, kMsh4,        kMsh4Binary,
                                              kVtk,         kVtkBinary, kUnv,        kMedit,       kNastran,
                                              kMeditBinary, kVtk5,      kVtu,        kVtuAppended, kAbaqus};

}  // namespace acus::test
