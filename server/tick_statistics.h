// SPDX-License-Identifier: GPL-3.0-or-later
// Gathers the ticks of one period of `stats`: their times as a distribution, everything else as its worst.
#pragma once

#include <algorithm>
#include <utility>
#include <vector>

#include "protocol/messages.h"
#include "server/link.h"

namespace acus {

class TickStatistics {
 public:
  TickStatistics() { seconds_.reserve(kMaxSamples); }

  void add(const TickRecord& tick) {
    if (seconds_.size() < kMaxSamples) seconds_.push_back(tick.seconds);
    ++worst_.ticks;
    worst_.tick_max = std::max(worst_.tick_max, tick.seconds);
    worst_.flags |= tick.flags;
    worst_.rows = std::max(worst_.rows, static_cast<std::uint32_t>(tick.rows));
    worst_.sweeps = std::max(worst_.sweeps, static_cast<std::uint32_t>(tick.sweeps));
    worst_.newton_iterations = std::max(worst_.newton_iterations, static_cast<std::uint32_t>(tick.newton_iterations));
    worst_.residual = std::max(worst_.residual, tick.residual);
    worst_.imbalance = std::max(worst_.imbalance, tick.imbalance);
    worst_.largest_force = std::max(worst_.largest_force, tick.largest_force);
  }

  // What was gathered, and begins anew. Fields that are not about ticks keep their defaults.
  protocol::Stats take() {
    protocol::Stats stats = std::exchange(worst_, {});
    stats.tick_p50 = quantile(0.50);
    stats.tick_p99 = quantile(0.99);
    seconds_.clear();
    return stats;
  }

 private:
  static constexpr std::size_t kMaxSamples = 1 << 17;  // of one period; further ticks count, but not for quantiles

  // The smallest tick time that a fraction q of the ticks does not exceed (s); 0 without ticks.
  double quantile(double q) {
    if (seconds_.empty()) return 0;
    const auto rank = static_cast<std::ptrdiff_t>(q * static_cast<double>(seconds_.size() - 1));
    std::nth_element(seconds_.begin(), seconds_.begin() + rank, seconds_.end());
    return seconds_[static_cast<std::size_t>(rank)];
  }

  protocol::Stats worst_;
  std::vector<double> seconds_;
};

}  // namespace acus
