// SPDX-License-Identifier: GPL-3.0-or-later
// Cell types: vtkCellType.h; node orders: https://docs.vtk.org, "VTK file formats".
#include "server/engine/mesh_files/formats/vtk_cells.h"

#include <cmath>

#include "server/engine/models/geometry/tetrahedral_mesh.h"

namespace acus {
namespace {

struct VtkType {
  std::int64_t number;
  std::size_t nodes;  // 0: any
  const char* flat;   // what is counted, or null for a volume
  ElementType volume;
};

constexpr std::array<VtkType, 40> kVtkTypes{{
    {0, 0, "empty cells", {}},
    {1, 1, "points", {}},
    {2, 0, "points", {}},
    {3, 2, "lines", {}},
    {4, 0, "lines", {}},
    {5, 3, "triangles", {}},
    {6, 0, "triangle strips", {}},
    {7, 0, "polygons", {}},
    {8, 4, "quadrangles", {}},
    {9, 4, "quadrangles", {}},
    {10, 4, nullptr, {Shape::tetrahedron, 4}},
    {11, 8, nullptr, {Shape::hexahedron, 8, {0, 1, 3, 2, 4, 5, 7, 6}}},
    {12, 8, nullptr, {Shape::hexahedron, 8}},
    {13, 6, nullptr, {Shape::prism, 6}},
    {14, 5, nullptr, {Shape::pyramid, 5}},
    {21, 3, "lines", {}},
    {22, 6, "triangles", {}},
    {23, 8, "quadrangles", {}},
    {24, 10, nullptr, {Shape::tetrahedron, 10}},
    {25, 20, nullptr, {Shape::hexahedron, 20}},
    {26, 15, nullptr, {Shape::prism, 15}},
    {27, 13, nullptr, {Shape::pyramid, 13}},
    {28, 9, "quadrangles", {}},
    {29, 27, nullptr, {Shape::hexahedron, 27}},
    {30, 6, "quadrangles", {}},
    {31, 12, nullptr, {Shape::prism, 12}},
    {32, 18, nullptr, {Shape::prism, 18}},
    {33, 24, nullptr, {Shape::hexahedron, 24}},
    {34, 7, "triangles", {}},
    {35, 4, "lines", {}},
    {36, 0, "polygons", {}},
    {37, 19, nullptr, {Shape::pyramid, 19}},
    {68, 0, "lines", {}},
    {69, 0, "triangles", {}},
    {70, 0, "quadrangles", {}},
    {71, 0, nullptr, {Shape::tetrahedron, 0}},
    {72, 0, nullptr, {Shape::hexahedron, 0}},
    {73, 0, nullptr, {Shape::prism, 0}},
    {74, 0, nullptr, {Shape::pyramid, 0}},
    {75, 0, "lines", {}},
}};

std::string cell_name(std::size_t cell) { return "cell " + std::to_string(cell); }

const VtkType& vtk_type(std::int64_t number, std::size_t cell) {
  for (const VtkType& type : kVtkTypes)
    if (type.number == number) return type;
  const std::string which = number == 42 ? " (polyhedron)" : "";
  throw MeshError(cell_name(cell) + " is of VTK's type " + std::to_string(number) + which +
                  ", which is not read; tetrahedralize it first, in ParaView with the filter Tetrahedralize");
}

// Adds one cell; returns its element, or -1 of a cell without volume.
int add_cell(std::int64_t number, std::size_t cell, std::span<const std::int64_t> points, std::int64_t first_node,
             MeshContents& contents) {
  const VtkType& type = vtk_type(number, cell);
  if (type.nodes != 0 && points.size() != type.nodes)
    throw MeshError(cell_name(cell) + ", of VTK's type " + std::to_string(number) + ", has " +
                    std::to_string(points.size()) + " points, expected " + std::to_string(type.nodes));
  if (type.flat) {
    ++contents.left_out[type.flat];
    return -1;
  }
  ElementType volume = type.volume;
  if (volume.nodes == 0) volume.nodes = points.size();  // Lagrange's cells: their corners come first
  if (volume.nodes < corner_count(volume.shape))
    throw MeshError(cell_name(cell) + " has " + std::to_string(points.size()) + " points, too few for its type");
  std::vector<std::int64_t> nodes(points.begin(), points.end());
  for (std::int64_t& node : nodes) node += first_node;
  contents.add_element(volume, static_cast<std::int64_t>(contents.elements.size()) + 1, kNoPlace, nodes);
  return static_cast<int>(contents.elements.size()) - 1;
}

// Cells that another piece has, too.
constexpr std::string_view kGhosts = "vtkGhostType";

const VtkCellArray* ghosts_of(const VtkGrid& grid) {
  for (const VtkCellArray& array : grid.cell_arrays)
    if (array.name == kGhosts && array.values.size() == grid.types.size()) return &array;
  return nullptr;
}

void add_points(const VtkGrid& grid, std::int64_t first_node, MeshContents& contents) {
  for (std::size_t i = 0; 3 * i < grid.points.size(); ++i) {
    const double* x = &grid.points[3 * i];
    if (!std::isfinite(x[0]) || !std::isfinite(x[1]) || !std::isfinite(x[2]))
      throw MeshError("point " + std::to_string(i) + " has a coordinate that is not finite");
    contents.nodes.push_back({first_node + static_cast<std::int64_t>(i), kNoPlace, {x[0], x[1], x[2]}});
  }
}

std::span<const std::int64_t> points_of(const VtkGrid& grid, std::size_t cell) {
  const auto entries = static_cast<std::int64_t>(grid.connectivity.size());
  const auto points = static_cast<std::int64_t>(grid.points.size() / 3);
  const std::int64_t begin = cell == 0 ? 0 : grid.offsets[cell - 1], end = grid.offsets[cell];
  if (end < begin || end > entries)
    throw MeshError(cell_name(cell) + " ends at entry " + std::to_string(end) + " of a connectivity of " +
                    std::to_string(entries));
  const auto its_points =
      std::span(grid.connectivity).subspan(static_cast<std::size_t>(begin), static_cast<std::size_t>(end - begin));
  for (const std::int64_t point : its_points)
    if (point < 0 || point >= points)
      throw MeshError(cell_name(cell) + " names point " + std::to_string(point) + ", expected 0 to " +
                      std::to_string(points - 1));
  return its_points;
}

}  // namespace

std::optional<std::vector<std::int64_t>> as_whole_numbers(std::span<const double> values) {
  constexpr double kMost = 1e15;  // exact in both
  std::vector<std::int64_t> whole;
  whole.reserve(values.size());
  for (const double value : values) {
    if (!(std::abs(value) < kMost) || value != std::floor(value)) return std::nullopt;
    whole.push_back(static_cast<std::int64_t>(value));
  }
  return whole;
}

std::vector<int> add_grid(const VtkGrid& grid, MeshContents& contents) {
  const auto first_node = static_cast<std::int64_t>(contents.nodes.size());
  add_points(grid, first_node, contents);
  if (grid.offsets.size() != grid.types.size())
    throw MeshError("the file lists " + std::to_string(grid.types.size()) + " cell types for " +
                    std::to_string(grid.offsets.size()) + " cells");
  const VtkCellArray* ghosts = ghosts_of(grid);
  std::vector<int> element_of_cell;
  for (std::size_t cell = 0; cell < grid.types.size(); ++cell) {
    const std::span<const std::int64_t> points = points_of(grid, cell);
    const bool ghost = ghosts && (ghosts->values[cell] & 1) != 0;
    element_of_cell.push_back(ghost ? -1 : add_cell(grid.types[cell], cell, points, first_node, contents));
  }
  const std::int64_t used = grid.offsets.empty() ? 0 : grid.offsets.back();
  if (used != static_cast<std::int64_t>(grid.connectivity.size()))
    throw MeshError("the connectivity has " + std::to_string(grid.connectivity.size()) + " entries, its cells use " +
                    std::to_string(used));
  return element_of_cell;
}

void add_cell_groups(std::span<const VtkCellArray> arrays, std::span<const int> element_of_cell,
                     MeshContents& contents) {
  for (const VtkCellArray& array : arrays) {
    if (array.values.size() != element_of_cell.size() || array.name == kGhosts) continue;
    std::vector<std::int64_t> of_elements(contents.elements.size());
    for (std::size_t cell = 0; cell < element_of_cell.size(); ++cell)
      if (element_of_cell[cell] >= 0) of_elements[static_cast<std::size_t>(element_of_cell[cell])] = array.values[cell];
    add_groups_of_array(array.name, of_elements, contents);
  }
}

}  // namespace acus
