// SPDX-License-Identifier: GPL-3.0-or-later
// Stage 9 of an insertion, at the new positions: contact, release, puncture, borders, growth of the path, exit, withdrawal.
// Works on the state of the next tick.
#pragma once

#include <cstdint>
#include <vector>

#include "server/simulation/report.h"
#include "server/simulation/insertion/insertion.h"

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

// Returns flags.
std::uint32_t insertion_transitions(const Transition& now);

// What a tip outside will touch first if it goes on along its axis for `distance` (m).
std::optional<ContactPatch> patch_ahead(const InsertionView& at, const Insertion& memory, double distance);
// The tetrahedron that a pushed tip gets to in `distance` (m) along its cutting direction, -1 if it lies in an old path
// or touches nothing.
int tetrahedron_ahead(const InsertionView& at, const InsertionWork& work, const Insertion& memory,
                      std::span<const Path> paths, double distance);

}  // namespace acus
