// SPDX-License-Identifier: GPL-3.0-or-later
// A box mesh that is its own mirror image in x, in y and under their exchange. make_box_mesh() cuts all cells around
// parallel diagonals, so that a straight push down its middle drifts sideways; here neighbouring cells are mirrored.
#pragma once

#include <array>
#include <string>

#include "server/math/types.h"

namespace acus::test {

// Writes it as a Gmsh file (version 2.2, metres), centred on the origin; even numbers of cells along x and y.
void write_mirrored_box(const std::string& file, const Vector3& size_m, const std::array<int, 3>& cells);

}  // namespace acus::test
