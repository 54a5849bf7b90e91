// SPDX-License-Identifier: GPL-3.0-or-later
// The stretches of a needle that the rows of its path hold, and those of its tip outside.
#pragma once

#include <algorithm>

#include "server/engine/tick/insertion/insertion.h"

namespace acus {

// Shaft so near to that stretch is held by it, too.
inline constexpr double kHeldBeside = 3e-3;  // m

struct HeldStretch {
  double from, to;  // m, along the needle: in its path
  double tip;       // m, from where on the tip outside holds it

  // Distance of a place along the needle from it (m), 0 inside.
  double apart(double s) const { return std::min(std::max({from - s, s - to, 0.0}), std::max(tip - s, 0.0)); }
};

// The tip holds what its compliance lets reach behind the mesh's surface, 2 mm where it touches nothing: a contact of
// the tip begins and ends without a jump.
HeldStretch held_stretch(const InsertionView& at, const Located& located, const Insertion& state);

}  // namespace acus
