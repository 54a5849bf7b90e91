// SPDX-License-Identifier: GPL-3.0-or-later
// A reader for each format, one a file. Each reads all volume elements of the file or throws MeshError with the line:
// counts that the file announces are held against what it has, and no element is passed over.
#pragma once

#include "server/engine/mesh_files/mesh_contents.h"

namespace acus {

// Gmsh 1, 2.x, 4.0 and 4.1, as text and binary. Groups: physical groups of volumes.
MeshContents read_msh(std::string_view bytes);
// Medit, as text (.mesh) and binary (.meshb). Groups: references.
MeshContents read_medit(std::string_view bytes);
// VTK's legacy files of all versions, as text and binary. Groups: integer cell arrays.
MeshContents read_vtk(std::string_view bytes);
// VTK's XML, .vtu: as text, base64 and appended, compressed with zlib or not. Groups: integer cell arrays.
MeshContents read_vtu(std::string_view bytes);
// Bulk data of Nastran and its relatives, in small, large and free fields. Groups: property numbers.
MeshContents read_nastran(std::string_view bytes);
// Input of Abaqus and CalculiX, with parts and instances. Groups: element sets.
MeshContents read_abaqus(std::string_view bytes);
// Universal files of I-DEAS, as Salome writes them. Groups: numbers of properties and materials, named groups.
MeshContents read_unv(std::string_view bytes);
// TetGen's .ele with its .node. Groups: the region attribute.
MeshContents read_tetgen(std::string_view elements, std::string_view nodes);

}  // namespace acus
