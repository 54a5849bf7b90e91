// SPDX-License-Identifier: GPL-3.0-or-later
// A number that changes when a bit changes of anything that a run depends on or tells: state and report of every tick.
#pragma once

#include <cstdint>
#include <memory>

#include "server/simulation/simulation.h"

struct XXH3_state_s;

namespace acus::test {

class TraceHash {
 public:
  TraceHash();

  // The tick that the simulation has just made, but for how long it took.
  void add(const Simulation& simulation);
  std::uint64_t value() const;

 private:
  void add_report(const TickReport& report);

  struct Free {
    void operator()(XXH3_state_s* state) const;
  };
  std::unique_ptr<XXH3_state_s, Free> state_;
};

}  // namespace acus::test
