// SPDX-License-Identifier: GPL-3.0-or-later
// Compiled with the simulation's flags. Holds a constant and no code, so that any processor can read it.
#include "server/runtime/instruction_set.h"

namespace acus {
namespace {

consteval FeatureSet bit(const char* name) {
  for (unsigned i = 0; i < kFeatureCount; ++i) {
    const char *a = kProcessorFeatures[i].name, *b = name;
    for (; *a && *a == *b; ++a) ++b;
    if (*a == *b) return 1u << i;
  }
  throw "no such feature";
}

}  // namespace

// clang-format off
constinit const FeatureSet kBuiltFor = 0
#ifdef __SSE3__
    | bit("SSE3")
#endif
#ifdef __SSSE3__
    | bit("SSSE3")
#endif
#ifdef __SSE4_1__
    | bit("SSE4.1")
#endif
#ifdef __SSE4_2__
    | bit("SSE4.2")
#endif
#ifdef __POPCNT__
    | bit("POPCNT")
#endif
#ifdef __AVX__
    | bit("AVX")
#endif
#ifdef __AVX2__
    | bit("AVX2")
#endif
#ifdef __BMI__
    | bit("BMI1")
#endif
#ifdef __BMI2__
    | bit("BMI2")
#endif
#ifdef __F16C__
    | bit("F16C")
#endif
#ifdef __FMA__
    | bit("FMA")
#endif
#ifdef __LZCNT__
    | bit("LZCNT")
#endif
#ifdef __MOVBE__
    | bit("MOVBE")
#endif
#ifdef __AVX512F__
    | bit("AVX512F")
#endif
#ifdef __AVX512BW__
    | bit("AVX512BW")
#endif
#ifdef __AVX512CD__
    | bit("AVX512CD")
#endif
#ifdef __AVX512DQ__
    | bit("AVX512DQ")
#endif
#ifdef __AVX512VL__
    | bit("AVX512VL")
#endif
    ;
// clang-format on

}  // namespace acus
