// SPDX-License-Identifier: MIT
// A set of times as a histogram in plain text.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <string>
#include <vector>

#include "client/replay/latency.h"

namespace acus::client {

inline constexpr std::size_t kHistogramRows = 16;     // that hold 99 % of the times; the last row holds the rest
inline constexpr std::size_t kHistogramColumns = 50;  // of the longest bar

// 1, 2 or 5 times a power of ten, not less than `value` > 0.
inline double round_up(double value) {
  const double decade = std::pow(10, std::floor(std::log10(value)));
  for (const double step : {1.0, 2.0, 5.0}) {
    if (value <= step * decade * (1 + 1e-9)) return step * decade;
  }
  return 10 * decade;
}

// One line per range of times, shorter ones than the first and longer ones than the last included there. Empty without
// times. `times` in s; lines are in ms.
inline std::string text_histogram(std::vector<double> times) {
  if (times.empty()) return {};
  std::sort(times.begin(), times.end());
  const double spread = std::max(percentile(times, 0.99) - times.front(), 1e-6);
  const double width = round_up(spread / kHistogramRows);
  const double begin = width * std::floor(times.front() / width);
  std::array<std::size_t, kHistogramRows + 2> counts{};
  for (const double time : times) {
    ++counts[static_cast<std::size_t>(std::min((time - begin) / width, static_cast<double>(counts.size() - 1)))];
  }
  const std::size_t largest = *std::max_element(counts.begin(), counts.end());
  std::string text;
  for (std::size_t row = 0; row < counts.size(); ++row) {
    const bool rest = row + 1 == counts.size();
    const std::size_t bar = (counts[row] * kHistogramColumns + largest - 1) / largest;  // what is there shows
    std::array<char, 64> label{};
    std::snprintf(label.data(), label.size(), "%8.3f %-4s %9zu ", 1e3 * (begin + static_cast<double>(row) * width),
                  rest ? "ms +" : "ms", counts[row]);
    text += label.data() + std::string(bar, '#') + '\n';
  }
  return text;
}

}  // namespace acus::client
