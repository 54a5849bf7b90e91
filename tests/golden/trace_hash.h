// SPDX-License-Identifier: GPL-3.0-or-later
// A number that changes when a bit changes of anything that a run depends on or tells: state and report of every tick.
#pragma once

#include <cstdint>

#include "server/engine/math/hasher.h"
#include "server/engine/tick/simulation.h"

namespace acus::test {

class TraceHash {
 public:
  // The tick that the simulation has just made, but for how long it took.
  void add(const Simulation& simulation);
  std::uint64_t value() const { return hasher_.digest(); }

 private:
  Hasher hasher_;
};

}  // namespace acus::test
