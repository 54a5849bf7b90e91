// SPDX-License-Identifier: GPL-3.0-or-later
// The loops that nearly all time of a tick goes into, the kernels, are compiled for the instruction set that the whole
// simulation needs, the baseline (ACUS_ARCH), and, where that is x86-64-v3, once more for x86-64-v4, whose registers
// (AVX-512) are twice as wide. A program takes the widest that its processor has; the environment variable
// ACUS_INSTRUCTION_SET names another (v3, v4).
//
// Both give the same bits (lanes.h), so nothing that a simulation tells, keeps or records depends on the choice.
//
// A file with a kernel (*_kernel.cpp) has all that it defines in the namespace ACUS_KERNEL, and uses inline functions
// of lanes.h and of its own alone: of others, Eigen's or the standard library's, the linker would keep one copy for the
// whole program, perhaps the one that only some processors can run. tests/architecture looks at the object files.
#pragma once

namespace acus {

enum class KernelSet { baseline, v4 };

// The set that this program uses. The first call decides; it throws std::runtime_error where ACUS_INSTRUCTION_SET names
// none that can be used.
KernelSet kernel_set();

// Uses another from now on, for tests: what has been computed so far stays as it is. The processor must have it.
void use_kernel_set(KernelSet set);

// v3, v4, or for what else the simulation was compiled.
const char* name_of(KernelSet set);

// Whether there is such a set, and this processor has it.
bool can_use(KernelSet set);

}  // namespace acus
