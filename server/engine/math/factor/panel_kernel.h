// SPDX-License-Identifier: GPL-3.0-or-later
// The substitutions with one panel (panel_values.h), compiled for each instruction set (kernel_set.h).
#pragma once

#include <cstddef>

namespace acus {

inline constexpr int kStripColumns = 6;  // two nodes
inline constexpr int kTileRows = 8;
inline constexpr int kStripAlignment = 16;  // numbers: a cache line of float, two of double

constexpr int round_up(int n, int multiple) { return (n + multiple - 1) / multiple * multiple; }

// Entries of the triangle of a strip, and of the strip.
constexpr int triangle_size(int width) { return 2 * kTileRows * width; }
constexpr int strip_size(int width, int below) {
  return round_up(triangle_size(width) + round_up(below, kTileRows) * width, kStripAlignment);
}

// What the numbers of panels are to be multiplied by, powers of two: those of triangles, and those of tiles.
struct PanelScale {
  double triangle = 1, tiles = 1;
};

// A panel of `columns` columns with `below` rows under their triangle. Right-hand sides as for PanelValues.
template <class Real>
struct PanelKernel {
  void (*forward_one)(const Real* panel, int columns, int below, PanelScale scale, double* w);
  void (*forward_three)(const Real* panel, int columns, int below, PanelScale scale, double* w, std::ptrdiff_t stride);
  void (*backward)(const Real* panel_end, int columns, int below, PanelScale scale, double* w);
};

// That of the chosen instruction set.
template <class Real>
const PanelKernel<Real>& panel_kernel();

}  // namespace acus
