// SPDX-License-Identifier: GPL-3.0-or-later
// Whether a piece of code calls the kernel: it runs in a forked child whose system calls a seccomp filter refuses.
// Linux only.
#pragma once

#include <functional>

namespace acus::test {

struct Sealed {
  bool watched = false;  // false: seccomp is not permitted here, or the child ended in an unforeseen way
  int system_call = -1;  // number of the first one that was made, which ended the work; -1: none
};

// What `work` changes stays in the child.
Sealed run_sealed(const std::function<void()>& work);

}  // namespace acus::test
