// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/math/kernel_set.h"

#include <cstdlib>
#include <stdexcept>
#include <string>

namespace acus {

namespace {

KernelSet chosen() {
  constexpr KernelSet kWidestFirst[] = {KernelSet::v4, KernelSet::baseline};
  const char* named = std::getenv("ACUS_INSTRUCTION_SET");
  const std::string wanted = named == nullptr ? "" : named;
  std::string usable;
  for (const KernelSet set : kWidestFirst) {
    if (!can_use(set)) continue;
    if (wanted.empty() || wanted == name_of(set)) return set;
    usable += (usable.empty() ? "" : " or ") + std::string(name_of(set));
  }
  throw std::runtime_error("ACUS_INSTRUCTION_SET: expected " + usable + " here, found '" + wanted + "'");
}

KernelSet& current() {
  static KernelSet set = chosen();
  return set;
}

}  // namespace

KernelSet kernel_set() { return current(); }
void use_kernel_set(KernelSet set) { current() = set; }

const char* name_of(KernelSet set) { return set == KernelSet::v4 ? "v4" : ACUS_BASELINE; }

bool can_use(KernelSet set) {
  if (set == KernelSet::baseline) return true;
#if ACUS_KERNELS_V4
  __builtin_cpu_init();
  return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
         __builtin_cpu_supports("avx512cd") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl");
#else
  return false;
#endif
}

}  // namespace acus
