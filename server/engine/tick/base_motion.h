// SPDX-License-Identifier: GPL-3.0-or-later
// How a needle's base, or a guide, follows its commands. Commands arrive in steps, at the client's rate and with the
// network's jitter. Two ways to continue between them:
//
// By the commands' own rhythm (the default). From the tick that takes a command in, the base goes to it evenly in n
// ticks, n what commands were apart of late: a mean m of the ticks between them and a mean deviation d from it, both
// over the last 16 or so, n = round(m + d). A steady motion that is sampled evenly is so followed evenly, with a lag of
// n ticks: the time between two commands, which is the least that a follower needs who does not guess. Commands at
// every tick are followed at once. After more than kPause without one the rhythm begins anew, with kFirstApproach.
//
// With a time constant tau. The base follows the newest command as a critically damped second-order system,
//
//   tau² x'' + 2 tau x' + (x - target) = 0,
//
// solved exactly over a tick for a target that stands still in it, so the motion does not depend on h but through the
// sampling of the targets. It comes to rest at the target without overshoot, has no corners, and lags behind a steady
// motion by 2 tau. tau = 0, or so small that a tick lasts for ever beside it: straight to the target.
//
// Either way a speed limit caps the step of every tick. Orientation and spin follow alike; orientation takes the
// shortest way.
#pragma once

#include <cstdint>
#include <optional>

#include "server/engine/state/needle/base_state.h"

namespace acus {

inline constexpr double kPause = 0.1;            // s without a command, after which their rhythm is forgotten
inline constexpr double kFirstApproach = 10e-3;  // s to a command that follows no other

// Finite, within the workspace, of unit orientation.
bool in_range(const Command& command);
// How far from where a base is it may be told to go.
struct StepLimits {
  double step = kInfinity, turn = kInfinity;  // m, rad
  bool reject = false;                        // beyond; else what is beyond is left out
};
enum class Acceptance : std::uint8_t { whole, clamped, rejected };
// Puts a command within the limits, unless it is to be rejected. A spin is left alone: max_spin_speed bounds it.
Acceptance limit(const StepLimits& limits, const Pose& base, Command& command);

// `pending` is replaced but for the fields that `newer` leaves out.
void merge(std::optional<Command>& pending, const Command& newer);

// Whether it goes as fast as it may.
bool at_speed_limit(const BaseLimits& limits, const BaseState& base);

// A command that brings the base to rest where it comes to by itself, wherever it was going.
Command come_to_rest(const BaseLimits& limits, const BaseState& base);

// The base one tick (h, s) later, on its way to the newest command, if there is one.
BaseState follow(const BaseLimits& limits, double h, const BaseState& base, const std::optional<Command>& newest,
                 std::uint64_t tick);

}  // namespace acus
