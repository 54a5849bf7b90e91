// SPDX-License-Identifier: MIT
// What acus-replay prints at the end of a run, as JSON for programs.
#pragma once

#include <string>

#include "client/replay/replay.h"
#include "client/replay/timing_limits.h"

namespace acus::client {

// Late ticks of the server, round trips of the poses. In real time.
MeasuredTiming measured_timing(const Replay& replay);

// One JSON object; times in milliseconds, lengths in metres, forces in newtons.
std::string run_summary(const Replay& replay, const ReplayOptions& options, const MeasuredTiming& measured,
                        const std::vector<TimingLimit>& limits);

}  // namespace acus::client
