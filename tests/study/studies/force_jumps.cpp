// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/study/studies/force_jumps.h"

#include <algorithm>

namespace acus {

std::vector<double> force_jumps(const std::vector<Vector3>& forces) {
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

ForceJump largest_unexplained(std::span<const TickReport> ticks, int needle) {
  std::vector<Vector3> forces;
  for (const TickReport& tick : ticks) {
    const NeedleReport& report = tick.needles[needle];
    forces.push_back(report.base.orientation.conjugate() * report.base_force);
  }
  const std::vector<double> jumps = force_jumps(forces);
  const auto happened = [&](const TickReport& tick) {
    return std::ranges::any_of(tick.events, [&](const Event& event) {
      return event.needle == needle && event.kind != EventKind::contact && event.kind != EventKind::release;
    });
  };
  ForceJump largest;
  for (std::size_t i = 0; i < ticks.size(); ++i) {
    const std::size_t first = i > kEarlierTicks ? i - kEarlierTicks : 0;
    if (std::ranges::any_of(ticks.subspan(first, i - first + 1), happened)) continue;
    if (jumps[i] > largest.size) largest = {jumps[i], i};
  }
  return largest;
}

}  // namespace acus
