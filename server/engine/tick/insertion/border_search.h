// SPDX-License-Identifier: GPL-3.0-or-later
// The border of a region that holds tips (state/borders.h) as a surface inside the tissue.
#pragma once

#include "server/engine/tick/insertion/insertion.h"

namespace acus {

// Puts the border that a tip at the end of its path rests against, or may reach in this tick, into located.obstacle. A tip
// that is not quite at the end may be back there, and beyond, by the end of the tick.
void find_border(const InsertionView& at, const Path& path, InsertionWork& work);

}  // namespace acus
