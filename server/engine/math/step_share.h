// SPDX-License-Identifier: GPL-3.0-or-later
// How much of a step to go. Along a step dx, whose matrix A is positive definite, a merit falls at first with the slope
// -d, d = dxᵀ A dx; where its slope at the end of a share of the step is above d, it has risen by the trapezoid rule.
#pragma once

#include <algorithm>
#include <cassert>

namespace acus {

// The next share to try after one at whose end the slope is `end`: where the secant through both slopes is zero, but
// between a tenth and a half of it; a tenth where `end` is not finite.
inline double cut_share(double share, double d, double end) {
  assert(share > 0 && share <= 1 && !(d < 0));
  const double secant = d / (d + end);
  return share * (secant > 0.1 ? std::min(secant, 0.5) : 0.1);
}

}  // namespace acus
