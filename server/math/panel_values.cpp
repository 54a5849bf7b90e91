// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/math/panel_values.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>

#ifdef __AVX512F__
#include <immintrin.h>
#endif

namespace acus {

namespace {

constexpr int kLine = 16;  // numbers: a cache line of float, two of double

constexpr int round_up(int n, int multiple) { return (n + multiple - 1) / multiple * multiple; }

// Entries of a strip, and of its triangle.
constexpr int triangle_size(int width) { return 2 * kTileRows * width; }
constexpr int strip_size(int width, int below) {
  return round_up(triangle_size(width) + round_up(below, kTileRows) * width, kLine);
}

// Calls visit(first column within the panel, width, rows below the strip) for the strips of a panel, in order.
template <class Visit>
void for_strips(const PanelTree::Panel& panel, Visit visit) {
  for (int j = 0; j < panel.columns; j += kStripColumns) {
    const int width = std::min(kStripColumns, panel.columns - j);
    visit(j, width, panel.columns - j - width + panel.below);
  }
}

std::ptrdiff_t panel_size(const PanelTree::Panel& panel) {
  std::ptrdiff_t size = 0;
  for_strips(panel, [&](int, int width, int below) { size += strip_size(width, below); });
  return size;
}

// Numbers too small for Real to hold them at full precision become zero: processors are slow with subnormal ones.
template <class Real>
Real rounded(double value) {
  return std::abs(value) < std::numeric_limits<Real>::min() ? Real{0} : static_cast<Real>(value);
}

// `columns` points to the diagonal entry of the strip's first column, columns are `rows` apart.
template <class Real>
void pack_strip(const double* columns, int rows, int width, int below, Real* strip) {
  const Eigen::Map<const MatrixX, 0, Eigen::OuterStride<>> block(columns, width + below, width,
                                                                 Eigen::OuterStride<>(rows));
  const MatrixX inverse =
      block.topRows(width).triangularView<Eigen::Lower>().solve(MatrixX::Identity(width, width));
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

// A column of a tile.
using Lane = double __attribute__((vector_size(kTileRows * sizeof(double))));
using LaneOfFloat = float __attribute__((vector_size(kTileRows * sizeof(float))));

inline Lane load(const double* p) {
  Lane v;
  std::memcpy(&v, p, sizeof v);
  return v;
}
inline Lane load(const float* p) {
  LaneOfFloat v;
  std::memcpy(&v, p, sizeof v);
#ifdef __AVX512F__
  return _mm512_maskz_cvtps_pd(0xff, v);  // gcc 12 makes two halves of the portable form
#else
  return __builtin_convertvector(v, Lane);
#endif
}
inline void store(double* p, const Lane& v) { std::memcpy(p, &v, sizeof v); }

// a0 + a1, a2 + a3, ... b6 + b7.
inline Lane pair_sums(const Lane& a, const Lane& b) {
  return __builtin_shufflevector(a, b, 0, 2, 4, 6, 8, 10, 12, 14) +
         __builtin_shufflevector(a, b, 1, 3, 5, 7, 9, 11, 13, 15);
}

// The sums over each of eight lanes.
inline Lane sums(const Lane (&v)[8]) {
  return pair_sums(pair_sums(pair_sums(v[0], v[1]), pair_sums(v[2], v[3])),
                   pair_sums(pair_sums(v[4], v[5]), pair_sums(v[6], v[7])));
}

// The columns of a tile times x, added up.
template <int width, class Real>
inline Lane product(const Real* tile, const double* x) {
  Lane result = load(tile) * x[0];
#pragma GCC unroll 8
  for (int j = 1; j < width; ++j) result += load(tile + j * kTileRows) * x[j];
  return result;
}

template <int width, int count, class Real>
inline void forward_strip(const Real* strip, int below, double* w, std::ptrdiff_t stride) {
  double x[count][kTileRows];
#pragma GCC unroll 3
  for (int r = 0; r < count; ++r) {
    store(x[r], product<width>(strip, w + r * stride));
#pragma GCC unroll 8
    for (int j = 0; j < width; ++j) w[r * stride + j] = x[r][j];
  }
  const Real* tile = strip + triangle_size(width);
  for (int i = 0; i < below; i += kTileRows, tile += kTileRows * width) {
    double* rows = w + width + i;
    Lane result[count];
#pragma GCC unroll 3
    for (int r = 0; r < count; ++r) result[r] = load(rows + r * stride);
#pragma GCC unroll 8
    for (int j = 0; j < width; ++j) {
      const Lane column = load(tile + j * kTileRows);
#pragma GCC unroll 3
      for (int r = 0; r < count; ++r) result[r] -= column * x[r][j];
    }
#pragma GCC unroll 3
    for (int r = 0; r < count; ++r) store(rows + r * stride, result[r]);
  }
}

template <int width, class Real>
inline void backward_strip(const Real* strip, int below, double* w) {
  static_assert(width <= 8);
  Lane products[8];
#pragma GCC unroll 8
  for (int j = 0; j < 8; ++j) products[j] = Lane{};
  const Real* tile = strip + triangle_size(width);
  for (int i = 0; i < below; i += kTileRows, tile += kTileRows * width) {
    const Lane rows = load(w + width + i);
#pragma GCC unroll 8
    for (int j = 0; j < width; ++j) products[j] += load(tile + j * kTileRows) * rows;
  }
  double x[kTileRows];
  store(x, load(w) - sums(products));
  store(x, product<width>(strip + kTileRows * width, x));
#pragma GCC unroll 8
  for (int j = 0; j < width; ++j) w[j] = x[j];
}

// Calls visit(std::integral_constant) with the width of a strip as a constant.
template <class Visit>
void with_width(int width, Visit visit) {
  static_assert(kStripColumns == 6);
  switch (width) {
    case 1: return visit(std::integral_constant<int, 1>{});
    case 2: return visit(std::integral_constant<int, 2>{});
    case 3: return visit(std::integral_constant<int, 3>{});
    case 4: return visit(std::integral_constant<int, 4>{});
    case 5: return visit(std::integral_constant<int, 5>{});
    default: return visit(std::integral_constant<int, 6>{});
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
  values_.setZero(size);
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
template <int count>
void PanelValues<Real>::forward(const PanelTree& tree, int s, double* w, std::ptrdiff_t stride) const {
  const Real* strip = values_.data() + start_[s];
  for_strips(tree.panels[s], [&](int j, int width, int below) {
    with_width(width, [&](auto constant) { forward_strip<constant(), count>(strip, below, w + j, stride); });
    strip += strip_size(width, below);
  });
}

template <class Real>
void PanelValues<Real>::backward(const PanelTree& tree, int s, double* w) const {
  const PanelTree::Panel& panel = tree.panels[s];
  const Real* strip = values_.data() + start_[s + 1];
  for (int j = (panel.columns - 1) / kStripColumns * kStripColumns; j >= 0; j -= kStripColumns) {
    const int width = std::min(kStripColumns, panel.columns - j), below = panel.columns - j - width + panel.below;
    strip -= strip_size(width, below);
    with_width(width, [&](auto constant) { backward_strip<constant()>(strip, below, w + j); });
  }
}

template class PanelValues<float>;
template class PanelValues<double>;
template void PanelValues<float>::forward<1>(const PanelTree&, int, double*, std::ptrdiff_t) const;
template void PanelValues<float>::forward<3>(const PanelTree&, int, double*, std::ptrdiff_t) const;
template void PanelValues<double>::forward<1>(const PanelTree&, int, double*, std::ptrdiff_t) const;
template void PanelValues<double>::forward<3>(const PanelTree&, int, double*, std::ptrdiff_t) const;

}  // namespace acus
