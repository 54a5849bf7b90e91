// SPDX-License-Identifier: GPL-3.0-or-later
// Counts what a piece of code asks of the heap or gives back, by standing in for malloc, free and their kin in the
// whole program, which operator new and delete, Eigen and CHOLMOD all end in. Link allocation_count.cpp into the
// program itself; the sanitizers need that place for themselves. GNU C library only.
#pragma once

namespace acus {

// Calls of malloc, calloc, realloc, aligned_alloc, memalign and posix_memalign, and of free with anything to free, by
// this thread while one of these lives. Only one at a time.
class AllocationCount {
 public:
  AllocationCount();
  ~AllocationCount();
  AllocationCount(const AllocationCount&) = delete;
  AllocationCount& operator=(const AllocationCount&) = delete;

  int value() const;  // so far
};

}  // namespace acus
