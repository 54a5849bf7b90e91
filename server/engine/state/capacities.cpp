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

int max_material_points(const Needle& parameters, double spacing) {
  return max_shaft_points(parameters, spacing) + 3 + kPatchPoints;
}

int max_touched_nodes(const Scene& scene) {
  const double spacing = least_spacing(scene.needles);
  int points = 0;
  for (const Needle& needle : scene.needles) points += max_material_points(needle, spacing);
  return 4 * points;
}

int max_held_nodes(const Scene& scene) {
  constexpr int kOfNeedle = 100;
  return max_touched_nodes(scene) + kOfNeedle * static_cast<int>(scene.needles.size());
}

int max_insertion_rows(const Needle& parameters, double spacing) {
  const int of_vertex = 4 + (parameters.torsional_friction > 0 ? 1 : 0);  // two across, friction, support; torsion
  constexpr int kOfTip = 5;                                               // cutting, border, two across, support
  return of_vertex * max_shaft_points(parameters, spacing) + kOfTip;
}

}  // namespace acus
