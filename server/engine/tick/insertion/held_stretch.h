// SPDX-License-Identifier: GPL-3.0-or-later
// The stretch of a needle that the rows of its path hold, or of its tip where that presses on a surface.
#pragma once

#include <algorithm>

#include "server/engine/tick/insertion/insertion.h"

namespace acus {

// Shaft so near to that stretch is held by it, too.
inline constexpr double kHeldBeside = 3e-3;  // m

struct HeldStretch {
  double from, to;  // m, along the needle

  // Distance of a place along the needle from it (m), 0 inside.
  double apart(double s) const { return std::max({from - s, s - to, 0.0}); }
};

// In contact, the stretch that the tip's compliance lets reach behind the mesh's surface.
HeldStretch held_stretch(const InsertionView& at, const Located& located, const Insertion& state);

}  // namespace acus
