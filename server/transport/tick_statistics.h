// SPDX-License-Identifier: GPL-3.0-or-later
// Gathers the ticks of one period of `stats`: their times as distributions, everything else as its worst.
#pragma once

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include "protocol/messages.h"
#include "server/engine/math/nearest_rank.h"
#include "server/runtime/link.h"

namespace acus {

class TickStatistics {
 public:
  void add(const TickRecord& tick) {
    computing_.add(tick.timing.computing);
    woke_.add(tick.timing.woke);
    ended_.add(tick.timing.ended);
    ++worst_.ticks;
    worst_.late += tick.timing.late ? 1 : 0;
    worst_.flags |= tick.flags;
    worst_.rows = std::max(worst_.rows, static_cast<std::uint32_t>(tick.rows));
    worst_.sweeps = std::max(worst_.sweeps, static_cast<std::uint32_t>(tick.sweeps));
    worst_.newton_iterations = std::max(worst_.newton_iterations, static_cast<std::uint32_t>(tick.newton_iterations));
    worst_.residual = std::max(worst_.residual, tick.residual);
    worst_.imbalance = std::max(worst_.imbalance, tick.imbalance);
    worst_.largest_force = std::max(worst_.largest_force, tick.largest_force);
  }

  std::uint64_t ticks() const { return worst_.ticks; }

  // What was gathered, and begins anew. Fields that are not about ticks keep their defaults.
  protocol::Stats take() {
    protocol::Stats stats = std::exchange(worst_, {});
    computing_.take(stats.tick_p50, stats.tick_p99, stats.tick_max);
    woke_.take(stats.wake_p50, stats.wake_p99, stats.wake_max);
    ended_.take(stats.end_p50, stats.end_p99, stats.end_max);
    return stats;
  }

 private:
  // The times (s) of one period.
  class Times {
   public:
    Times() { seconds_.reserve(kMaxSamples); }

    void add(double seconds) {
      if (seconds_.size() < kMaxSamples) seconds_.push_back(seconds);
      max_ = std::max(max_, seconds);
    }

    void take(double& p50, double& p99, double& max) {
      p50 = nearest_rank(seconds_, 0.50);
      p99 = nearest_rank(seconds_, 0.99);
      max = std::exchange(max_, 0);
      seconds_.clear();
    }

   private:
    static constexpr std::size_t kMaxSamples = 1 << 17;  // further ticks count, but not for quantiles

    std::vector<double> seconds_;
    double max_ = 0;
  };

  protocol::Stats worst_;
  Times computing_, woke_, ended_;
};

}  // namespace acus
