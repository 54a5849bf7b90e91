// SPDX-License-Identifier: GPL-3.0-or-later
// The distribution of delays over a run of any length, in bounded memory: counts in bins whose edges grow by a constant
// factor, from 1 us to 16 s. Quantiles are upper edges of bins, so too large by at most 4.5 %; the largest delay is
// exact, and stands for all beyond 16 s.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace acus {

class DelayHistogram {
 public:
  void add(double seconds) {
    ++bins_[bin_of(seconds)];
    ++count_;
    max_ = std::max(max_, seconds);
  }

  std::uint64_t count() const { return count_; }
  double max() const { return max_; }  // s

  // A delay (s) that a fraction q in [0, 1] of those added does not exceed; 0 if there are none.
  double quantile(double q) const {
    const double rank = q * static_cast<double>(count_);
    std::uint64_t below = 0;
    for (std::size_t bin = 0; bin + 1 < bins_.size(); ++bin) {
      below += bins_[bin];
      if (below > 0 && static_cast<double>(below) >= rank) return std::min(upper_edge(bin), max_);
    }
    return max_;
  }

 private:
  static constexpr double kSmallest = 1e-6;     // s, upper edge of the first bin
  static constexpr double kBinsPerOctave = 16;  // the factor between two edges is the 16th root of 2
  static constexpr std::size_t kBins = 24 * 16;

  static std::size_t bin_of(double seconds) {
    if (!(seconds > kSmallest)) return 0;
    const double bin = std::ceil(kBinsPerOctave * std::log2(seconds / kSmallest));
    return static_cast<std::size_t>(std::min(bin, static_cast<double>(kBins - 1)));
  }
  static double upper_edge(std::size_t bin) { return kSmallest * std::exp2(static_cast<double>(bin) / kBinsPerOctave); }

  std::array<std::uint64_t, kBins> bins_{};
  std::uint64_t count_ = 0;
  double max_ = 0;
};

}  // namespace acus
