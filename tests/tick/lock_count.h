// SPDX-License-Identifier: GPL-3.0-or-later
// Counts the locks that a piece of code takes or waits for, by standing in for the functions of the C library which
// std::mutex, OpenBLAS and all others call.
#pragma once

namespace acus::test {

// Mutexes, read-write locks and semaphores, by this thread while one of these lives. Only one at a time. Threads that
// libraries keep for themselves are left out.
class LockCount {
 public:
  LockCount();
  ~LockCount();
  LockCount(const LockCount&) = delete;
  LockCount& operator=(const LockCount&) = delete;

  int value() const;  // so far
};

}  // namespace acus::test
