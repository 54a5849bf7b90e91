// SPDX-License-Identifier: GPL-3.0-or-later
// When frames are due: so many a second of simulation time, the first after the first tick.
#pragma once

#include <cstdint>

#include "server/engine/recording/rerun.h"

namespace acus {

class FrameClock {
 public:
  explicit FrameClock(double rate) : period_(1 / rate) {}  // Hz

  // Whether a frame is due after this tick. Half a tick of tolerance keeps sums of time steps from being a tick late.
  bool due(const Rerun& rerun) {
    const double time = rerun.seconds() + rerun.simulation().model().h / 2;
    if (time < next()) return false;
    while (time >= next()) ++frames_;
    return true;
  }

 private:
  double next() const { return static_cast<double>(frames_) * period_; }

  const double period_;  // s
  std::uint64_t frames_ = 0;
};

}  // namespace acus
