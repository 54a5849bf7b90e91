// SPDX-License-Identifier: GPL-3.0-or-later
// Whether a piece of code calls the kernel: it runs in a forked child whose system calls a seccomp filter refuses.
// Linux only.
#pragma once

#include <sys/mman.h>

#include <functional>
#include <new>

namespace acus::test {

struct Sealed {
  bool watched = false;  // false: seccomp is not permitted here, or the child ended in an unforeseen way
  int system_call = -1;  // number of the first one that was made, which ended the work; -1: none
};

// A value in memory that a forked child shares with its parent.
template <class T>
class SharedWithChild {
 public:
  SharedWithChild()
      : value_(new (mmap(nullptr, sizeof(T), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0)) T) {}
  ~SharedWithChild() { munmap(value_, sizeof(T)); }
  SharedWithChild(const SharedWithChild&) = delete;
  SharedWithChild& operator=(const SharedWithChild&) = delete;

  T& operator*() const { return *value_; }
  T* operator->() const { return value_; }

 private:
  T* value_;
};

// What `work` changes stays in the child, unless it is shared with it.
Sealed run_sealed(const std::function<void()>& work);

}  // namespace acus::test
