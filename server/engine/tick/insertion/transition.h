// SPDX-License-Identifier: GPL-3.0-or-later
// What the transitions of a needle (path_transitions.h, surface_transitions.h) share: what they look at and what they change.
#pragma once

#include <cstdint>
#include <vector>

#include "server/engine/state/report.h"
#include "server/engine/tick/insertion/insertion.h"

namespace acus {

// A tip that touches nothing and stands deeper than this in the tissue has got there without a puncture.
inline constexpr double kUnnoticed = 1e-3;  // m

// What a needle's transitions look at and change. The needle's shape and the tissue of `at` are those of the tick's end.
struct Transition {
  const InsertionView& at;
  const InsertionWork& work;
  std::uint64_t tick;
  Insertion& memory;
  std::vector<Path>& paths;
  std::vector<Event>& events;  // never beyond its capacity

  void report(EventKind kind, int region, double force) const;
};

}  // namespace acus
