// SPDX-License-Identifier: GPL-3.0-or-later
// Eight numbers side by side in the compiler's vectors: one AVX-512 register, two or four of smaller machines. And the
// way between them and the four numbers of one node or quaternion, which stand together in memory.
#pragma once

#include <cmath>
#include <cstring>

namespace acus {

inline constexpr int kLanes = 8;
using Lanes = double __attribute__((vector_size(kLanes * sizeof(double))));
using Quad = double __attribute__((vector_size(4 * sizeof(double))));

// Whether a comparison holds, in all lanes.
using LaneMask = decltype(Lanes{} < Lanes{});
inline bool all(bool holds) { return holds; }
inline bool all(const LaneMask& holds) {
  const LaneMask pairs = holds & __builtin_shufflevector(holds, holds, 4, 5, 6, 7, 0, 1, 2, 3);
  return (pairs[0] & pairs[1] & pairs[2] & pairs[3]) != 0;
}

inline double square_root(double x) { return std::sqrt(x); }
inline Lanes square_root(const Lanes& x) {
  Lanes y;
  for (int i = 0; i < kLanes; ++i) y[i] = std::sqrt(x[i]);
  return y;
}

inline Quad load_quad(const double* p) {
  Quad q;
  std::memcpy(&q, p, sizeof q);
  return q;
}

// *p += q
inline void add_quad(double* p, const Quad& q) {
  const Quad sum = load_quad(p) + q;
  std::memcpy(p, &sum, sizeof sum);
}

// lanes[c][i] = quads[i][c]
inline void transpose(const Quad (&quads)[kLanes], Lanes (&lanes)[4]) {
  Lanes pairs[4];
#pragma GCC unroll 4
  for (int i = 0; i < 4; ++i)
    pairs[i] = __builtin_shufflevector(quads[2 * i], quads[2 * i + 1], 0, 1, 2, 3, 4, 5, 6, 7);
  const Lanes low01 = __builtin_shufflevector(pairs[0], pairs[1], 0, 4, 8, 12, 1, 5, 9, 13);
  const Lanes high01 = __builtin_shufflevector(pairs[2], pairs[3], 0, 4, 8, 12, 1, 5, 9, 13);
  const Lanes low23 = __builtin_shufflevector(pairs[0], pairs[1], 2, 6, 10, 14, 3, 7, 11, 15);
  const Lanes high23 = __builtin_shufflevector(pairs[2], pairs[3], 2, 6, 10, 14, 3, 7, 11, 15);
  lanes[0] = __builtin_shufflevector(low01, high01, 0, 1, 2, 3, 8, 9, 10, 11);
  lanes[1] = __builtin_shufflevector(low01, high01, 4, 5, 6, 7, 12, 13, 14, 15);
  lanes[2] = __builtin_shufflevector(low23, high23, 0, 1, 2, 3, 8, 9, 10, 11);
  lanes[3] = __builtin_shufflevector(low23, high23, 4, 5, 6, 7, 12, 13, 14, 15);
}

// quads[i][c] = lanes[c][i]
inline void transpose(const Lanes& a, const Lanes& b, const Lanes& c, const Lanes& d, Quad (&quads)[kLanes]) {
  const Lanes ab_low = __builtin_shufflevector(a, b, 0, 8, 1, 9, 2, 10, 3, 11);
  const Lanes ab_high = __builtin_shufflevector(a, b, 4, 12, 5, 13, 6, 14, 7, 15);
  const Lanes cd_low = __builtin_shufflevector(c, d, 0, 8, 1, 9, 2, 10, 3, 11);
  const Lanes cd_high = __builtin_shufflevector(c, d, 4, 12, 5, 13, 6, 14, 7, 15);
  quads[0] = __builtin_shufflevector(ab_low, cd_low, 0, 1, 8, 9);
  quads[1] = __builtin_shufflevector(ab_low, cd_low, 2, 3, 10, 11);
  quads[2] = __builtin_shufflevector(ab_low, cd_low, 4, 5, 12, 13);
  quads[3] = __builtin_shufflevector(ab_low, cd_low, 6, 7, 14, 15);
  quads[4] = __builtin_shufflevector(ab_high, cd_high, 0, 1, 8, 9);
  quads[5] = __builtin_shufflevector(ab_high, cd_high, 2, 3, 10, 11);
  quads[6] = __builtin_shufflevector(ab_high, cd_high, 4, 5, 12, 13);
  quads[7] = __builtin_shufflevector(ab_high, cd_high, 6, 7, 14, 15);
}

}  // namespace acus
