// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/simulation/insertion/insertion.h"

#include <cmath>

namespace acus {

int max_shaft_points(const Needle& parameters) {
  return 2 * static_cast<int>(std::ceil(parameters.length / parameters.constraint_spacing)) + 4;
}

int max_insertion_rows(const Needle& parameters) {
  return (parameters.torsional_friction > 0 ? 5 : 4) * max_shaft_points(parameters) + 5;
}

int max_material_points(const Needle& parameters) { return max_shaft_points(parameters) + 4; }

Vector3 InsertionView::cutting_direction() const {
  return needle.shape.frames.back() * parameters.cutting_direction.normalized();
}

InsertionWork::InsertionWork(const Needle& parameters, int path_capacity)
    : next(make_insertion(path_capacity)), turned(path_capacity) {
  located.shaft = Bounded<ShaftPoint>(static_cast<std::size_t>(max_shaft_points(parameters)));
}

}  // namespace acus
