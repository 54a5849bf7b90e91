// SPDX-License-Identifier: MIT
// Order statistics of a set of times.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace acus::client {

// Nearest-rank percentile of rising values, `fraction` in [0, 1]: the smallest value that at least that fraction of
// the values does not exceed. Zero if there are none.
inline double percentile(const std::vector<double>& sorted, double fraction) {
  if (sorted.empty()) return 0;
  const double rank = std::ceil(fraction * static_cast<double>(sorted.size()));
  const auto index = static_cast<std::size_t>(std::max(rank, 1.0)) - 1;
  return sorted[std::min(index, sorted.size() - 1)];
}

// In the unit of the values.
struct Distribution {
  std::size_t count = 0;
  double p50 = 0;
  double p99 = 0;
  double max = 0;
};

inline Distribution distribution_of(std::vector<double> values) {
  if (values.empty()) return {};
  std::sort(values.begin(), values.end());
  return {values.size(), percentile(values, 0.5), percentile(values, 0.99), values.back()};
}

}  // namespace acus::client
