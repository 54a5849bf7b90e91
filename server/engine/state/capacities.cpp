// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/state/capacities.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace acus {

double least_spacing(std::span<const Needle> needles) {
  double least = kInfinity;
  for (const Needle& needle : needles) least = std::min(least, needle.constraint_spacing);
  return least;
}

int max_shaft_points(const Needle& parameters, double spacing) {
  assert(spacing > 0 && spacing < kInfinity);
  return 2 * static_cast<int>(std::ceil(parameters.length / spacing)) + 4;
}

int max_insertion_rows(const Needle& parameters, double spacing) {
  const int of_vertex = 4 + (parameters.torsional_friction > 0 ? 1 : 0);  // two across, friction, support; torsion
  constexpr int kOfTip = 5;                                               // cutting, border, two across, support
  return of_vertex * max_shaft_points(parameters, spacing) + kOfTip;
}

}  // namespace acus
