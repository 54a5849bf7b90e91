// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/math/factor/panel_values.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "server/engine/math/kernel_set.h"

namespace acus {

namespace baseline {
extern const PanelKernel<float> panel_kernel_of_float;
extern const PanelKernel<double> panel_kernel_of_double;
extern const PanelKernel<Float16> panel_kernel_of_float16;
}  // namespace baseline
#if ACUS_KERNELS_V4
namespace v4 {
extern const PanelKernel<float> panel_kernel_of_float;
extern const PanelKernel<double> panel_kernel_of_double;
extern const PanelKernel<Float16> panel_kernel_of_float16;
}  // namespace v4
#else
namespace v4 = baseline;
#endif

template <>
const PanelKernel<float>& panel_kernel() {
  return kernel_set() == KernelSet::v4 ? v4::panel_kernel_of_float : baseline::panel_kernel_of_float;
}
template <>
const PanelKernel<double>& panel_kernel() {
  return kernel_set() == KernelSet::v4 ? v4::panel_kernel_of_double : baseline::panel_kernel_of_double;
}

template <>
const PanelKernel<Float16>& panel_kernel() {
  return kernel_set() == KernelSet::v4 ? v4::panel_kernel_of_float16 : baseline::panel_kernel_of_float16;
}

namespace {

// Calls visit(first column within the panel, width, rows below the strip) for the strips of a panel, in order.
template <class Visit>
void for_strips(const PanelTree::Panel& panel, Visit visit) {
  for (int j = 0; j < panel.columns; j += kStripColumns) {
    const int width = std::min(kStripColumns, panel.columns - j);
    visit(j, width, panel.columns - j - width + panel.below);
  }
}

// Of the strips before a column, or of all.
std::ptrdiff_t size_before(const PanelTree::Panel& panel, int column) {
  std::ptrdiff_t size = 0;
  for_strips(panel, [&](int j, int width, int below) { size += j < column ? strip_size(width, below) : 0; });
  return size;
}
std::ptrdiff_t panel_size(const PanelTree::Panel& panel) { return size_before(panel, panel.columns); }

// Numbers too small for Real to hold them at full precision become zero: processors are slow with subnormal ones.
template <class Real>
Real rounded(double value) {
  return std::abs(value) < std::numeric_limits<Real>::min() ? Real{0} : static_cast<Real>(value);
}

constexpr double kLeastFloat16 = 0x1p-14;
constexpr int kLargestExponent = 14;  // of what rounds to a Float16: below 2^15

// To the nearest; of two as near, to the even one.
template <>
Float16 rounded(double value) {
  if (std::abs(value) < kLeastFloat16) return {};
  const auto bits = std::bit_cast<std::uint32_t>(static_cast<float>(value));
  const std::uint32_t size = (bits & 0x7fffffff) - ((127 - 15) << 23);
  return {static_cast<unsigned short>((bits >> 16 & 0x8000) | (size + 0xfff + (size >> 13 & 1)) >> 13)};
}

// The columns of a strip from their diagonal on: triangle, then the rows below it.
struct StripColumns {
  StripColumns(const double* diagonal, int rows, int width, int below)
      : block(diagonal, width + below, width, Eigen::OuterStride<>(rows)),
        inverse(block.topRows(width).triangularView<Eigen::Lower>().solve(MatrixX::Identity(width, width))) {}

  Eigen::Map<const MatrixX, 0, Eigen::OuterStride<>> block;  // columns are `rows` apart
  MatrixX inverse;                                           // of the triangle
};

// Calls visit(StripColumns, width, below) for all strips of L, in the order in which they are kept.
template <class Visit>
void for_columns(const PanelTree& tree, const double* x, const int* start, Visit visit) {
  for (std::size_t s = 0; s < tree.panels.size(); ++s) {
    const PanelTree::Panel& panel = tree.panels[s];
    const int rows = panel.columns + panel.below;
    for_strips(panel, [&](int j, int width, int below) {
      visit(StripColumns(x + start[s] + static_cast<std::ptrdiff_t>(j) * rows + j, rows, width, below), width, below);
    });
  }
}

double power_for(double largest) { return std::ldexp(1, kLargestExponent - (largest > 0 ? std::ilogb(largest) : 0)); }

// What numbers are multiplied by to be kept.
template <class Real>
PanelScale scale_to_keep(const PanelTree&, const double*, const int*) {
  return {};
}
template <>
PanelScale scale_to_keep<Float16>(const PanelTree& tree, const double* x, const int* start) {
  PanelScale largest{.triangle = 0, .tiles = 0};
  for_columns(tree, x, start, [&](const StripColumns& strip, int, int below) {
    largest.triangle = std::max(largest.triangle, strip.inverse.cwiseAbs().maxCoeff());
    if (below > 0) largest.tiles = std::max(largest.tiles, strip.block.bottomRows(below).cwiseAbs().maxCoeff());
  });
  return {power_for(largest.triangle), power_for(largest.tiles)};
}

template <class Real>
void pack_strip(const StripColumns& columns, int width, int below, PanelScale scale, Real* strip) {
  for (int j = 0; j < width; ++j) {
    for (int i = 0; i < width; ++i) {
      strip[j * kTileRows + i] = rounded<Real>(scale.triangle * columns.inverse(i, j));
      strip[(width + j) * kTileRows + i] = rounded<Real>(scale.triangle * columns.inverse(j, i));
    }
    Real* tiles = strip + triangle_size(width) + j * kTileRows;
    for (int i = 0; i < below; ++i)
      tiles[i / kTileRows * kTileRows * width + i % kTileRows] =
          rounded<Real>(scale.tiles * columns.block(width + i, j));
  }
}

}  // namespace

std::size_t kept_entries(const PanelTree& tree) {
  std::ptrdiff_t size = 0;
  for (const PanelTree::Panel& panel : tree.panels) size += panel_size(panel);
  return static_cast<std::size_t>(size);
}

template <class Real>
void PanelValues<Real>::pack(const PanelTree& tree, const double* x, const int* start) {
  start_.clear();
  std::ptrdiff_t size = 0;
  for (const PanelTree::Panel& panel : tree.panels) {
    start_.push_back(size);
    size += panel_size(panel);
  }
  start_.push_back(size);
  values_.assign(static_cast<std::size_t>(size), Real{});
  const PanelScale scale = scale_to_keep<Real>(tree, x, start);
  scale_ = {1 / scale.triangle, 1 / scale.tiles};
  Real* strip = values_.data();
  for_columns(tree, x, start, [&](const StripColumns& columns, int width, int below) {
    pack_strip(columns, width, below, scale, strip);
    strip += strip_size(width, below);
  });
}

template <class Real>
void PanelValues<Real>::forward(const PanelTree& tree, int s, int first, int last, double* w) const {
  const PanelTree::Panel& all = tree.panels[s];
  const Real* strips = panel(s) + (first > 0 ? size_before(all, first) : 0);
  panel_kernel<Real>().forward_one(strips, last - first, all.columns - last + all.below, scale_, w + first);
}

template <class Real>
void PanelValues<Real>::forward_three(const PanelTree& tree, int s, int first, int last, double* w,
                                      std::ptrdiff_t stride) const {
  const PanelTree::Panel& all = tree.panels[s];
  const Real* strips = panel(s) + (first > 0 ? size_before(all, first) : 0);
  panel_kernel<Real>().forward_three(strips, last - first, all.columns - last + all.below, scale_, w + first, stride);
}

template <class Real>
void PanelValues<Real>::backward(const PanelTree& tree, int s, int first, int last, double* w) const {
  const PanelTree::Panel& all = tree.panels[s];
  const Real* end = last < all.columns ? panel(s) + size_before(all, last) : panel(s + 1);
  panel_kernel<Real>().backward(end, last - first, all.columns - last + all.below, scale_, w + first);
}

template class PanelValues<float>;
template class PanelValues<double>;
template class PanelValues<Float16>;

}  // namespace acus
