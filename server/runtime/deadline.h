// SPDX-License-Identifier: GPL-3.0-or-later
// The grid of deadlines on which a real-time loop runs: start, start + period, start + 2 period, ... (ns of
// CLOCK_MONOTONIC). A loop that is late continues at the next deadline still ahead; the ones in between are skipped and
// never made up for.
#pragma once

#include <cstdint>

namespace acus {

struct Deadline {
  std::int64_t time = 0;      // ns
  std::uint64_t skipped = 0;  // deadlines between the previous one and this that had passed already
};

// The deadline to wait for once the work begun at `previous` is done. `period` > 0.
constexpr Deadline next_deadline(std::int64_t previous, std::int64_t period, std::int64_t now) {
  const std::int64_t next = previous + period;
  if (now <= next) return {next, 0};
  const std::int64_t skipped = (now - next + period - 1) / period;
  return {next + skipped * period, static_cast<std::uint64_t>(skipped)};
}

}  // namespace acus
