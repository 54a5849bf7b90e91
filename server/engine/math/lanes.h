// SPDX-License-Identifier: GPL-3.0-or-later
// Eight numbers side by side, in memory (Octet) and in vector registers (Lanes: one register of AVX-512, else two
// halves), and the way between them and the four numbers of one node or quaternion (Quad), which stand together in
// memory.
//
// What is computed with Lanes does not depend on the registers: every operation is that of IEEE 754 on each number,
// sums across numbers are taken in one order, and products are fused with sums where multiply_add() says so and nowhere
// else (files with such code are compiled with -ffp-contract=off, see kernel_set.h).
#pragma once

#if defined(__AVX__)
#include <immintrin.h>
#endif

// Files that are compiled once for every instruction set say which; its functions and types are others in each of them.
#ifndef ACUS_KERNEL
#define ACUS_KERNEL here
#endif

namespace acus {

inline constexpr int kLanes = 8;

struct alignas(kLanes * sizeof(double)) Octet {
  double at[kLanes];

  double& operator[](int i) { return at[i]; }
  const double& operator[](int i) const { return at[i]; }
};

// Half precision, IEEE 754 binary16: eleven bits of mantissa, 6e-5 to 65504; none below that but zero is ever kept.
struct Float16 {
  unsigned short bits;
};

inline namespace ACUS_KERNEL {

using Quad = double __attribute__((vector_size(4 * sizeof(double))));
using QuadOfFloat = float __attribute__((vector_size(4 * sizeof(float))));

#if defined(__AVX512F__)
using Half = double __attribute__((vector_size(kLanes * sizeof(double))));  // there is but one
#else
using Half = Quad;
#endif
using HalfMask = decltype(Half{} < Half{});

template <class Register>
struct InRegisters {
  Register low;
#if !defined(__AVX512F__)
  Register high;
#endif
};

using Halves = InRegisters<Half>;

// f of the registers of all operands, one after the other.
template <class F, class... Operands>
inline auto by_registers(F f, const Operands&... operands) {
#if defined(__AVX512F__)
  return InRegisters<decltype(f(operands.low...))>{f(operands.low...)};
#else
  return InRegisters<decltype(f(operands.low...))>{f(operands.low...), f(operands.high...)};
#endif
}

// Whether a comparison holds, per number.
struct LaneMask : InRegisters<HalfMask> {
  LaneMask(const InRegisters<HalfMask>& registers) : InRegisters<HalfMask>(registers) {}
  friend LaneMask operator&(const LaneMask& a, const LaneMask& b) {
    return by_registers([](HalfMask x, HalfMask y) { return x & y; }, a, b);
  }
};

struct Lanes : Halves {
  Lanes() = default;
  Lanes(const Halves& registers) : Halves(registers) {}
  Lanes(double all);
  Lanes(const Octet& octet) : Lanes(load(octet.at)) {}

  static Lanes load(const double* p);
  static Lanes load(const float* p);
  static Lanes load(const Float16* p);
  void store(double* p) const;

  friend Lanes operator+(const Lanes& a, const Lanes& b) {
    return by_registers([](Half x, Half y) { return x + y; }, a, b);
  }
  friend Lanes operator-(const Lanes& a, const Lanes& b) {
    return by_registers([](Half x, Half y) { return x - y; }, a, b);
  }
  friend Lanes operator*(const Lanes& a, const Lanes& b) {
    return by_registers([](Half x, Half y) { return x * y; }, a, b);
  }
  friend Lanes operator/(const Lanes& a, const Lanes& b) {
    return by_registers([](Half x, Half y) { return x / y; }, a, b);
  }
  friend Lanes operator-(const Lanes& a) {
    return by_registers([](Half x) { return -x; }, a);
  }
  friend LaneMask operator>(const Lanes& a, const Lanes& b) {
    return by_registers([](Half x, Half y) { return x > y; }, a, b);
  }
  friend LaneMask operator<(const Lanes& a, const Lanes& b) { return b > a; }
  friend LaneMask operator<=(const Lanes& a, const Lanes& b) {
    return by_registers([](Half x, Half y) { return x <= y; }, a, b);
  }
};

inline Lanes::Lanes(double all) {
#if defined(__AVX512F__)
  low = _mm512_set1_pd(all);
#else
  low = high = Half{all, all, all, all};
#endif
}

// Register by register: gcc 12 copies a struct of two by way of memory.
inline Lanes Lanes::load(const double* p) {
  Halves lanes;
  __builtin_memcpy(&lanes.low, p, sizeof lanes.low);
#if !defined(__AVX512F__)
  __builtin_memcpy(&lanes.high, p + 4, sizeof lanes.high);
#endif
  return lanes;
}
inline void Lanes::store(double* p) const {
  __builtin_memcpy(p, &low, sizeof low);
#if !defined(__AVX512F__)
  __builtin_memcpy(p + 4, &high, sizeof high);
#endif
}

inline Lanes Lanes::load(const float* p) {
#if defined(__AVX512F__)
  return Halves{_mm512_maskz_cvtps_pd(0xff, _mm256_loadu_ps(p))};  // gcc 12 makes two halves of the portable form
#elif defined(__AVX__)
  return Halves{_mm256_cvtps_pd(_mm_loadu_ps(p)), _mm256_cvtps_pd(_mm_loadu_ps(p + 4))};
#else
  QuadOfFloat low, high;
  __builtin_memcpy(&low, p, sizeof low);
  __builtin_memcpy(&high, p + 4, sizeof high);
  return Halves{__builtin_convertvector(low, Quad), __builtin_convertvector(high, Quad)};
#endif
}

inline Lanes Lanes::load(const Float16* p) {
#if defined(__AVX512F__)
  return Halves{_mm512_maskz_cvtps_pd(0xff, _mm256_cvtph_ps(_mm_loadu_si128(reinterpret_cast<const __m128i*>(p))))};
#elif defined(__F16C__)
  const auto four = [](const Float16* at) {
    return _mm256_cvtps_pd(_mm_cvtph_ps(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(at))));
  };
  return Halves{four(p), four(p + 4)};
#else
  float numbers[kLanes];
  for (int i = 0; i < kLanes; ++i) {
    constexpr unsigned kExponents = (127 - 15) << 23;  // between the zeros of both
    const unsigned bits = p[i].bits, size = bits & 0x7fff;
    const unsigned wide = size == 0 ? 0 : (bits & 0x8000) << 16 | ((size << 13) + kExponents);
    __builtin_memcpy(numbers + i, &wide, sizeof wide);
  }
  return load(numbers);
#endif
}

// a b + c, rounded once where the processor can.
inline Half multiply_add(Half a, Half b, Half c) {
#if defined(__AVX512F__)
  return _mm512_fmadd_pd(a, b, c);
#elif defined(__FMA__)
  return _mm256_fmadd_pd(a, b, c);
#else
  return a * b + c;
#endif
}
inline Lanes multiply_add(const Lanes& a, const Lanes& b, const Lanes& c) {
  return by_registers([](Half x, Half y, Half z) { return multiply_add(x, y, z); }, a, b, c);
}

inline bool all(bool holds) { return holds; }
inline bool all(const LaneMask& holds) {
#if defined(__AVX512F__)
  const auto four = __builtin_shufflevector(holds.low, holds.low, 0, 1, 2, 3) &
                    __builtin_shufflevector(holds.low, holds.low, 4, 5, 6, 7);
#else
  const auto four = holds.low & holds.high;
#endif
  return (four[0] & four[1] & four[2] & four[3]) != 0;
}

// a where the mask holds, else b.
inline double select(bool mask, double a, double b) { return mask ? a : b; }
inline Lanes select(const LaneMask& mask, const Lanes& a, const Lanes& b) {
  return by_registers([](HalfMask m, Half x, Half y) { return m ? x : y; }, mask, a, b);
}

inline double square_root(double x) { return __builtin_sqrt(x); }
inline Lanes square_root(const Lanes& x) {
  return by_registers(
      [](Half y) {
#if defined(__AVX512F__)
        return Half(_mm512_maskz_sqrt_pd(0xff, y));
#elif defined(__AVX__)
        return Half(_mm256_sqrt_pd(y));
#else
        for (int i = 0; i < 4; ++i) y[i] = __builtin_sqrt(y[i]);
        return y;
#endif
      },
      x);
}

inline Quad load_quad(const double* p) {
  Quad q;
  __builtin_memcpy(&q, p, sizeof q);
  return q;
}

// *p += q
inline void add_quad(double* p, const Quad& q) {
  const Quad sum = load_quad(p) + q;
  __builtin_memcpy(p, &sum, sizeof sum);
}

// Numbers 0 to 3 and 4 to 7.
inline Quad low_quad(const Lanes& lanes) {
#if defined(__AVX512F__)
  return __builtin_shufflevector(lanes.low, lanes.low, 0, 1, 2, 3);
#else
  return lanes.low;
#endif
}
inline Quad high_quad(const Lanes& lanes) {
#if defined(__AVX512F__)
  return __builtin_shufflevector(lanes.low, lanes.low, 4, 5, 6, 7);
#else
  return lanes.high;
#endif
}
inline Lanes both_quads(const Quad& low, const Quad& high) {
#if defined(__AVX512F__)
  return Halves{__builtin_shufflevector(low, high, 0, 1, 2, 3, 4, 5, 6, 7)};
#else
  return Halves{low, high};
#endif
}

// columns[j][i] = rows[i][j]
inline void transpose(const Quad (&rows)[4], Quad (&columns)[4]) {
  const Quad even01 = __builtin_shufflevector(rows[0], rows[1], 0, 4, 2, 6);
  const Quad even23 = __builtin_shufflevector(rows[2], rows[3], 0, 4, 2, 6);
  const Quad odd01 = __builtin_shufflevector(rows[0], rows[1], 1, 5, 3, 7);
  const Quad odd23 = __builtin_shufflevector(rows[2], rows[3], 1, 5, 3, 7);
  columns[0] = __builtin_shufflevector(even01, even23, 0, 1, 4, 5);
  columns[1] = __builtin_shufflevector(odd01, odd23, 0, 1, 4, 5);
  columns[2] = __builtin_shufflevector(even01, even23, 2, 3, 6, 7);
  columns[3] = __builtin_shufflevector(odd01, odd23, 2, 3, 6, 7);
}

// lanes[c] has number c of each quad.
inline void transpose(const Quad (&quads)[kLanes], Lanes (&lanes)[4]) {
  const Quad first[4] = {quads[0], quads[1], quads[2], quads[3]}, last[4] = {quads[4], quads[5], quads[6], quads[7]};
  Quad low[4], high[4];
  transpose(first, low);
  transpose(last, high);
#pragma GCC unroll 4
  for (int c = 0; c < 4; ++c) lanes[c] = both_quads(low[c], high[c]);
}

// Quad i has number i of each of the lanes.
inline void transpose(const Lanes& a, const Lanes& b, const Lanes& c, const Lanes& d, Quad (&quads)[kLanes]) {
  const Quad low[4] = {low_quad(a), low_quad(b), low_quad(c), low_quad(d)};
  const Quad high[4] = {high_quad(a), high_quad(b), high_quad(c), high_quad(d)};
  Quad first[4], last[4];
  transpose(low, first);
  transpose(high, last);
#pragma GCC unroll 4
  for (int i = 0; i < 4; ++i) quads[i] = first[i], quads[i + 4] = last[i];
}

// Number j is the sum of the numbers of v[j]: those of each quad by pairs, then both quads.
inline Lanes sums(const Lanes (&v)[kLanes]) {
  Quad quads[2][2];  // of v[0] to v[3] and v[4] to v[7]; low and high quads
#pragma GCC unroll 2
  for (int h = 0; h < 2; ++h) {
    const Lanes* four = v + 4 * h;
    const Quad low[4] = {low_quad(four[0]), low_quad(four[1]), low_quad(four[2]), low_quad(four[3])};
    const Quad high[4] = {high_quad(four[0]), high_quad(four[1]), high_quad(four[2]), high_quad(four[3])};
    Quad columns[4];
    transpose(low, columns);
    quads[h][0] = (columns[0] + columns[1]) + (columns[2] + columns[3]);
    transpose(high, columns);
    quads[h][1] = (columns[0] + columns[1]) + (columns[2] + columns[3]);
  }
  return both_quads(quads[0][0] + quads[0][1], quads[1][0] + quads[1][1]);
}

}  // namespace ACUS_KERNEL
}  // namespace acus
