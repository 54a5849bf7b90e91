// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/golden/trace_hash.h"

#include "server/engine/state/bytes/report_hash.h"
#include "server/engine/state/bytes/state_bytes.h"

namespace acus::test {

void TraceHash::add(const Simulation& simulation) {
  add_report(hasher_, simulation.report());
  const std::uint64_t state = hash(simulation.state());
  hasher_.bytes(&state, sizeof state);
}

}  // namespace acus::test
