// SPDX-License-Identifier: GPL-3.0-or-later
// What a hand feels as a click: the change of a force from one tick to the next, less that of the ticks around it. Of the
// three ticks before and the three after, those count that explain more of it, so that a force which rises steadily,
// however fast, or begins to, does not jump. acus-plot --jumps finds the same in a recording.
#pragma once

#include <span>
#include <vector>

#include "server/engine/state/report.h"

namespace acus {

// The jump (N) of each tick against the one before; the first has none.
std::vector<double> force_jumps(const std::vector<Vector3>& forces);

struct ForceJump {
  double size = 0;       // N
  std::size_t tick = 0;  // index of the tick that has the other force
};

// Ticks before a jump in which its cause may lie.
inline constexpr std::size_t kEarlierTicks = 5;

// The largest jump of a needle's base force, in its base's frame, without an event of the needle in its tick or just
// before. A contact or a release is where a force begins or ends: it explains none.
ForceJump largest_unexplained(std::span<const TickReport> ticks, int needle);

}  // namespace acus
