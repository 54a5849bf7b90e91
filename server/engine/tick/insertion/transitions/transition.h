// SPDX-License-Identifier: GPL-3.0-or-later
// What transitions of a needle (path_transitions.h, surface_transitions.h) read and change.
#pragma once

#include <cstdint>
#include <vector>

#include "server/engine/state/report.h"
#include "server/engine/tick/insertion/insertion.h"

namespace acus {

// `at`: needle and tissue at the end of the tick.
struct Transition {
  const InsertionView& at;
  const InsertionScratch& scratch;
  std::uint64_t tick;
  Insertion& state;
  std::vector<Path>& paths;
  std::vector<Event>& events;  // never beyond its capacity

  void report(EventKind kind, int region, double force) const;                           // at the tip
  void report(EventKind kind, int region, double force, const Vector3& position) const;  // m, world
};

}  // namespace acus
