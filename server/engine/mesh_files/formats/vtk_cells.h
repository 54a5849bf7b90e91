// SPDX-License-Identifier: GPL-3.0-or-later
// What VTK's two formats share: an unstructured grid as arrays, and its cells as elements.
#pragma once

#include <optional>

#include "server/engine/mesh_files/mesh_contents.h"

namespace acus {

// A one-component array of whole numbers, one per cell.
struct VtkCellArray {
  std::string name;
  std::vector<std::int64_t> values;
};

struct VtkGrid {
  std::vector<double> points;              // 3 per point
  std::vector<std::int64_t> connectivity;  // points of all cells, one cell after the other
  std::vector<std::int64_t> offsets;       // one per cell: where it ends in `connectivity`
  std::vector<std::int64_t> types;         // one per cell
  std::vector<VtkCellArray> cell_arrays;
};

// The values as whole numbers, or nothing where one is none.
std::optional<std::vector<std::int64_t>> as_whole_numbers(std::span<const double> values);

// Adds the grid to what a file holds, where nodes are numbered from 0. Returns the element of each cell, -1 for cells
// without volume. Throws MeshError where the grid's arrays do not fit together.
std::vector<int> add_grid(const VtkGrid& grid, MeshContents& contents);
// Groups of arrays that have a value for every cell.
void add_cell_groups(std::span<const VtkCellArray> arrays, std::span<const int> element_of_cell,
                     MeshContents& contents);

}  // namespace acus
