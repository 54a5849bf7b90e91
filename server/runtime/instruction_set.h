// SPDX-License-Identifier: GPL-3.0-or-later
// What the simulation's code asks of the processor, checked before anything else runs: programs that link
// acus_instruction_set end at once, with kWrongProcessor and a message, where the processor lacks what they were
// compiled for. Without it they would end in the first vector instruction, without a word.
#pragma once

#include <cstddef>

namespace acus {

inline constexpr int kWrongProcessor = 4;  // status with which the programs end

// Extensions of x86-64 that compilers use, and the level (x86-64-v2, -v3, -v4) that asks for them first.
struct ProcessorFeature {
  const char* name;
  int level;
};
inline constexpr ProcessorFeature kProcessorFeatures[] = {
    {"SSE3", 2},  {"SSSE3", 2},   {"SSE4.1", 2},   {"SSE4.2", 2},   {"POPCNT", 2},   {"AVX", 3},
    {"AVX2", 3},  {"BMI1", 3},    {"BMI2", 3},     {"F16C", 3},     {"FMA", 3},      {"LZCNT", 3},
    {"MOVBE", 3}, {"AVX512F", 4}, {"AVX512BW", 4}, {"AVX512CD", 4}, {"AVX512DQ", 4}, {"AVX512VL", 4}};
inline constexpr unsigned kFeatureCount = sizeof kProcessorFeatures / sizeof *kProcessorFeatures;

// Bit i stands for kProcessorFeatures[i].
using FeatureSet = unsigned;

// What the simulation was compiled for.
extern const FeatureSet kBuiltFor;

FeatureSet processor_features();

// Largest level of x86-64 of which nothing is missing, from 1.
int processor_level(FeatureSet has);

// Writes the message for a processor that has less than the program needs, and ends it with a null character; an empty
// one where nothing is missing.
void explain_missing_features(const char* program, FeatureSet needed, FeatureSet has, char* text, std::size_t size);

}  // namespace acus
