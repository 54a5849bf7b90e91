// SPDX-License-Identifier: GPL-3.0-or-later
// Gmsh does not free what it read before it gave up on a damaged file. A few hundred bytes per refused file are not
// ours to mend; link this where tests read meshes, so that the leak sanitizer looks at our own memory only.
extern "C" const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() { return "leak:libgmsh\n"; }
