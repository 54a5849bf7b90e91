// SPDX-License-Identifier: GPL-3.0-or-later
// Whether the events of a tick explain how a needle's phase has changed (state/needle/phase.h).
#pragma once

#include <array>
#include <vector>

#include "server/engine/state/needle/phase.h"
#include "server/engine/state/report.h"

namespace acus::test {

// Along the arrows, each with its event, in the order of the events.
inline bool explained(const std::vector<Event>& events, int needle, Phase from, Phase to) {
  std::array<bool, 4> reached{};
  reached[static_cast<std::size_t>(from)] = true;
  for (const Event& event : events) {
    if (event.needle != needle) continue;
    const std::array<bool, 4> before = reached;
    for (const PhaseChange& change : kPhaseChanges)
      if (change.event == event.kind && before[static_cast<std::size_t>(change.from)])
        reached[static_cast<std::size_t>(change.to)] = true;
  }
  return reached[static_cast<std::size_t>(to)];
}

}  // namespace acus::test
