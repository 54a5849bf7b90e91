// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/math/panel_values.h"

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
extern const PanelKernel<Bfloat16> panel_kernel_of_bfloat16;
}  // namespace baseline
#if ACUS_KERNELS_V4
namespace v4 {
extern const PanelKernel<float> panel_kernel_of_float;
extern const PanelKernel<double> panel_kernel_of_double;
extern const PanelKernel<Bfloat16> panel_kernel_of_bfloat16;
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
const PanelKernel<Bfloat16>& panel_kernel() {
  return kernel_set() == KernelSet::v4 ? v4::panel_kernel_of_bfloat16 : baseline::panel_kernel_of_bfloat16;
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

// To the nearest; of two as near, to the even one.
template <>
Bfloat16 rounded(double value) {
  const auto bits = std::bit_cast<std::uint32_t>(rounded<float>(value));
  return {static_cast<unsigned short>((bits + 0x7fff + (bits >> 16 & 1)) >> 16)};
}

// `columns` points to the diagonal entry of the strip's first column, columns are `rows` apart.
template <class Real>
void pack_strip(const double* columns, int rows, int width, int below, Real* strip) {
  const Eigen::Map<const MatrixX, 0, Eigen::OuterStride<>> block(columns, width + below, width,
                                                                 Eigen::OuterStride<>(rows));
  const MatrixX inverse = block.topRows(width).triangularView<Eigen::Lower>().solve(MatrixX::Identity(width, width));
  for (int j = 0; j < width; ++j) {
    for (int i = 0; i < width; ++i) {
      strip[j * kTileRows + i] = rounded<Real>(inverse(i, j));
      strip[(width + j) * kTileRows + i] = rounded<Real>(inverse(j, i));
    }
    Real* tiles = strip + triangle_size(width) + j * kTileRows;
    for (int i = 0; i < below; ++i)
      tiles[i / kTileRows * kTileRows * width + i % kTileRows] = rounded<Real>(block(width + i, j));
  }
}

}  // namespace

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
  for (std::size_t s = 0; s < tree.panels.size(); ++s) {
    const PanelTree::Panel& panel = tree.panels[s];
    const int rows = panel.columns + panel.below;
    Real* strip = values_.data() + start_[s];
    for_strips(panel, [&](int j, int width, int below) {
      pack_strip(x + start[s] + static_cast<std::ptrdiff_t>(j) * rows + j, rows, width, below, strip);
      strip += strip_size(width, below);
    });
  }
}

template <class Real>
void PanelValues<Real>::forward(const PanelTree& tree, int s, int first, int last, double* w) const {
  const PanelTree::Panel& all = tree.panels[s];
  const Real* strips = panel(s) + (first > 0 ? size_before(all, first) : 0);
  panel_kernel<Real>().forward_one(strips, last - first, all.columns - last + all.below, w + first);
}

template <class Real>
void PanelValues<Real>::forward_three(const PanelTree& tree, int s, double* w, std::ptrdiff_t stride) const {
  panel_kernel<Real>().forward_three(panel(s), tree.panels[s].columns, tree.panels[s].below, w, stride);
}

template <class Real>
void PanelValues<Real>::backward(const PanelTree& tree, int s, int first, int last, double* w) const {
  const PanelTree::Panel& all = tree.panels[s];
  const Real* end = last < all.columns ? panel(s) + size_before(all, last) : panel(s + 1);
  panel_kernel<Real>().backward(end, last - first, all.columns - last + all.below, w + first);
}

template class PanelValues<float>;
template class PanelValues<double>;
template class PanelValues<Bfloat16>;

}  // namespace acus
