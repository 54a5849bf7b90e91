// SPDX-License-Identifier: GPL-3.0-or-later
// Compiled once for every instruction set: see kernel_set.h for what such files may contain.
#include "server/engine/math/factor/panel_kernel.h"

#include "server/engine/math/lanes.h"

namespace acus {
inline namespace ACUS_KERNEL {
namespace {

// The columns of a tile times x, added up.
template <int width, class Real>
inline Lanes product(const Real* tile, const double* x) {
  Lanes result = Lanes::load(tile) * x[0];
#pragma GCC unroll 8
  for (int j = 1; j < width; ++j) result = multiply_add(Lanes::load(tile + j * kTileRows), x[j], result);
  return result;
}

// Asks for the cache lines of `count` numbers.
template <int count, class Real>
inline void prefetch(const Real* numbers) {
  constexpr int kLine = 64 / sizeof(Real);
#pragma GCC unroll 8
  for (int i = 0; i < count; i += kLine) __builtin_prefetch(numbers + i);
}

template <int width, int count, class Real>
inline void forward_strip(const Real* strip, int below, PanelScale scale, double* w, std::ptrdiff_t stride) {
  double x[count][kTileRows];  // with the sign of what is taken off
#pragma GCC unroll 3
  for (int r = 0; r < count; ++r) {
    (product<width>(strip, w + r * stride) * scale.triangle).store(x[r]);
#pragma GCC unroll 8
    for (int j = 0; j < width; ++j) {
      w[r * stride + j] = x[r][j];
      x[r][j] *= -scale.tiles;
    }
  }
  const Real* tile = strip + triangle_size(width);
  const std::ptrdiff_t size = strip_size(width, below);
  for (int i = 0; i < below; i += kTileRows, tile += kTileRows * width) {
    prefetch<kTileRows * width>(tile + size);
    double* rows = w + width + i;
    Lanes result[count];
#pragma GCC unroll 3
    for (int r = 0; r < count; ++r) result[r] = Lanes::load(rows + r * stride);
#pragma GCC unroll 8
    for (int j = 0; j < width; ++j) {
      const Lanes column = Lanes::load(tile + j * kTileRows);
#pragma GCC unroll 3
      for (int r = 0; r < count; ++r) result[r] = multiply_add(column, x[r][j], result[r]);
    }
#pragma GCC unroll 3
    for (int r = 0; r < count; ++r) result[r].store(rows + r * stride);
  }
}

template <int width, class Real>
inline void backward_strip(const Real* strip, int below, PanelScale scale, double* w) {
  static_assert(width <= kLanes);
  Lanes products[kLanes];
#pragma GCC unroll 8
  for (int j = 0; j < kLanes; ++j) products[j] = 0.0;
  const Real* tile = strip + triangle_size(width);
  const std::ptrdiff_t size = strip_size(width, below);
  for (int i = 0; i < below; i += kTileRows, tile += kTileRows * width) {
    prefetch<kTileRows * width>(tile - size);
    const Lanes rows = Lanes::load(w + width + i);
#pragma GCC unroll 8
    for (int j = 0; j < width; ++j) products[j] = multiply_add(Lanes::load(tile + j * kTileRows), rows, products[j]);
  }
  double x[kTileRows];
  (Lanes::load(w) - sums(products) * scale.tiles).store(x);
  (product<width>(strip + kTileRows * width, x) * scale.triangle).store(x);
#pragma GCC unroll 8
  for (int j = 0; j < width; ++j) w[j] = x[j];
}

template <int n>
struct Width {
  static constexpr int value = n;
};

// Calls visit(Width<width>) for the width of a strip.
template <class Visit>
inline void with_width(int width, Visit visit) {
  static_assert(kStripColumns == 6);
  switch (width) {
    case 1:
      return visit(Width<1>{});
    case 2:
      return visit(Width<2>{});
    case 3:
      return visit(Width<3>{});
    case 4:
      return visit(Width<4>{});
    case 5:
      return visit(Width<5>{});
    default:
      return visit(Width<6>{});
  }
}

template <int count, class Real>
void forward(const Real* strip, int columns, int below, PanelScale scale, double* w, std::ptrdiff_t stride) {
  for (int j = 0; j < columns; j += kStripColumns) {
    const int width = columns - j < kStripColumns ? columns - j : kStripColumns, under = columns - j - width + below;
    with_width(width, [=](auto constant) {
      forward_strip<decltype(constant)::value, count>(strip, under, scale, w + j, stride);
    });
    strip += strip_size(width, under);
  }
}

template <class Real>
void forward_one(const Real* panel, int columns, int below, PanelScale scale, double* w) {
  forward<1>(panel, columns, below, scale, w, 0);
}

template <class Real>
void backward(const Real* strip, int columns, int below, PanelScale scale, double* w) {
  for (int j = (columns - 1) / kStripColumns * kStripColumns; j >= 0; j -= kStripColumns) {
    const int width = columns - j < kStripColumns ? columns - j : kStripColumns, under = columns - j - width + below;
    strip -= strip_size(width, under);
    with_width(width, [=](auto constant) { backward_strip<decltype(constant)::value>(strip, under, scale, w + j); });
  }
}

}  // namespace

extern const PanelKernel<float> panel_kernel_of_float{forward_one<float>, forward<3, float>, backward<float>};
extern const PanelKernel<Float16> panel_kernel_of_float16{forward_one<Float16>, forward<3, Float16>, backward<Float16>};
extern const PanelKernel<double> panel_kernel_of_double{forward_one<double>, forward<3, double>, backward<double>};

}  // namespace ACUS_KERNEL
}  // namespace acus
