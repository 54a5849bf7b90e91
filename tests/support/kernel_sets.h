// SPDX-License-Identifier: GPL-3.0-or-later
// The same computation with the kernels of two instruction sets.
#pragma once

#include <utility>

#include "server/engine/math/kernel_set.h"
#include "tests/support/shared_data.h"

namespace acus::test {

// Whether there is nothing to compare here; the test is told as skipped then.
inline bool only_one_set() {
  if (can_use(KernelSet::v4)) return false;
  print_skipped("this processor, or this build, has no kernels for x86-64-v4");
  return true;
}

// What `compute` returns with those of the baseline and with those of x86-64-v4.
template <class Compute>
auto with_both_sets(Compute compute) {
  const KernelSet before = kernel_set();
  use_kernel_set(KernelSet::baseline);
  auto narrow = compute();
  use_kernel_set(KernelSet::v4);
  auto wide = compute();
  use_kernel_set(before);
  return std::pair(std::move(narrow), std::move(wide));
}

}  // namespace acus::test
