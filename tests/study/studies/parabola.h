// SPDX-License-Identifier: GPL-3.0-or-later
// The curvature of a measured curve, from a parabola y = c0 + c1 x + c2 x² fitted by least squares.
#pragma once

#include <vector>

namespace acus {

// At `middle` (m), of the parabola through points (x, y) in m: 2 c2 / (1 + (c1 + 2 c2 middle)²)^(3/2), in 1/m. Needs as many
// xs as ys, three different ones among them.
double parabola_curvature(const std::vector<double>& xs, const std::vector<double>& ys, double middle);

}  // namespace acus
