// SPDX-License-Identifier: GPL-3.0-or-later
// Compiled for the oldest processor. Inline functions of the standard library must not occur here: the linker keeps one
// copy of each, and that may come from a file compiled for a newer processor.
#include "server/runtime/instruction_set.h"

#include <errno.h>
#include <string.h>
#include <unistd.h>

namespace acus {
namespace {

struct Text {
  char* begin;
  std::size_t size, used;

  void add(const char* more) {
    for (; *more && used + 1 < size; ++more) begin[used++] = *more;
    begin[used] = '\0';
  }
};

void add_level(Text& text, int level) {
  text.add("x86-64");
  const char suffix[] = {'-', 'v', static_cast<char>('0' + level), '\0'};
  if (level > 1) text.add(suffix);
}

// Before the constructors of all other objects of the program.
[[gnu::constructor(101)]] void check_processor() {
  char text[512];
  explain_missing_features(program_invocation_short_name, kBuiltFor, processor_features(), text, sizeof text);
  if (!*text) return;
  [[maybe_unused]] const auto written = write(STDERR_FILENO, text, strlen(text));
  _exit(kWrongProcessor);
}

}  // namespace

FeatureSet processor_features() {
  FeatureSet set = 0;
#ifdef __x86_64__
  __builtin_cpu_init();
#ifdef __clang__  // has no names for these three, which every processor with AVX2 has
  const int f16c = __builtin_cpu_supports("avx2"), lzcnt = f16c, movbe = f16c;
#else
  const int f16c = __builtin_cpu_supports("f16c"), lzcnt = __builtin_cpu_supports("lzcnt"),
            movbe = __builtin_cpu_supports("movbe");
#endif
  const int has[] = {
      __builtin_cpu_supports("sse3"),     __builtin_cpu_supports("ssse3"),    __builtin_cpu_supports("sse4.1"),
      __builtin_cpu_supports("sse4.2"),   __builtin_cpu_supports("popcnt"),   __builtin_cpu_supports("avx"),
      __builtin_cpu_supports("avx2"),     __builtin_cpu_supports("bmi"),      __builtin_cpu_supports("bmi2"),
      f16c,                               __builtin_cpu_supports("fma"),      lzcnt,
      movbe,                              __builtin_cpu_supports("avx512f"),  __builtin_cpu_supports("avx512bw"),
      __builtin_cpu_supports("avx512cd"), __builtin_cpu_supports("avx512dq"), __builtin_cpu_supports("avx512vl")};
  static_assert(sizeof has / sizeof *has == kFeatureCount);
  for (unsigned i = 0; i < kFeatureCount; ++i)
    if (has[i]) set |= 1u << i;
#endif
  return set;
}

int processor_level(FeatureSet has) {
  int level = 4;
  for (unsigned i = 0; i < kFeatureCount; ++i)
    if (!(has >> i & 1) && kProcessorFeatures[i].level <= level) level = kProcessorFeatures[i].level - 1;
  return level;
}

void explain_missing_features(const char* program, FeatureSet needed, FeatureSet has, char* text, std::size_t size) {
  Text message{text, size, 0};
  message.add("");
  const FeatureSet missing = needed & ~has;
  if (!missing) return;
  message.add(program);
  message.add(": this processor lacks ");
  bool first = true;
  for (unsigned i = 0; i < kFeatureCount; ++i) {
    if (!(missing >> i & 1)) continue;
    if (!first) message.add(", ");
    message.add(kProcessorFeatures[i].name);
    first = false;
  }
  message.add(", for which the program was built; build it with -DACUS_ARCH=");
  add_level(message, processor_level(has));
  message.add("\n");
}

}  // namespace acus
