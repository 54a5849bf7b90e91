// SPDX-License-Identifier: GPL-3.0-or-later
// What acus-mesh gives up before it reads a file, which might turn a reader against it.
#pragma once

#include <sys/resource.h>

namespace acus {

// Bounds memory and processor time, and makes this process the first to go where memory ends.
void limit_resources(rlim_t memory_bytes, rlim_t processor_seconds);

// From here on the process can read what it has open and compute: every other system call is refused, where the kernel
// knows such filters (x86-64, aarch64). It has no capabilities, and started by root it goes on as user 65534, nobody,
// where there is one.
void confine();

}  // namespace acus
