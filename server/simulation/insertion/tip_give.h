// SPDX-License-Identifier: GPL-3.0-or-later
// What gives way under a tip that the mesh does not resolve (m/N); local_compliance.h has the laws.
#pragma once

#include "server/simulation/insertion/insertion.h"

namespace acus {

// On the surface that it rests against.
double surface_compliance(const InsertionView& at, const Obstacle& obstacle);
// At the end of its path.
double cutting_compliance(const InsertionView& at, const Path& path);
// Across its way: of its end, and of the length of shaft that it stands for beside it.
double hold_compliance(const InsertionView& at, const TipPlace& place);
// At a border, where what lies before the tip is pressed flat by f_c; `contact` (N): what it bore at the last tick's end.
double border_compliance(const InsertionView& at, const Path& path, double contact);

}  // namespace acus
