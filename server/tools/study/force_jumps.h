// SPDX-License-Identifier: GPL-3.0-or-later
// What a hand feels as a click: the change of a force from one tick to the next, less that of the ticks around it. Of the
// three ticks before and the three after, those count that explain more of it, so that a force which rises steadily,
// however fast, or begins to, does not jump. client/jumps finds the same in a recording.
#pragma once

#include <algorithm>
#include <vector>

#include "server/math/types.h"

namespace acus {

// The jump (N) of each tick against the one before; the first has none.
inline std::vector<double> force_jumps(const std::vector<Vector3>& forces) {
  constexpr int kAround = 3;
  const int count = static_cast<int>(forces.size());
  const auto change = [&](int i) -> Vector3 { return forces[i] - forces[i - 1]; };
  // The changes of [first, last], as far as there are any.
  const auto beyond = [&](int i, int first, int last) {
    first = std::max(1, first), last = std::min(count - 1, last);
    if (first > last) return kInfinity;
    const Vector3 mean = (forces[last] - forces[first - 1]) / (last - first + 1);
    return (change(i) - mean).norm();
  };
  std::vector<double> jumps(forces.size(), 0.0);
  for (int i = 1; i < count; ++i) {
    const double jump = std::min(beyond(i, i - kAround, i - 1), beyond(i, i + 1, i + kAround));
    jumps[i] = jump < kInfinity ? jump : 0;
  }
  return jumps;
}

}  // namespace acus
