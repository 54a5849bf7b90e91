// SPDX-License-Identifier: GPL-3.0-or-later
// How a needle's base, or a guide, follows commands, which arrive at the client's rate with the network's jitter.
//
// By the commands' own rhythm (default): the base goes to a command evenly in n ticks, n = round(m + d), m the mean and
// d the mean deviation of the ticks between the last 16 commands or so. An evenly sampled motion is followed evenly,
// with a lag of n ticks; commands at every tick at once. After kPause without one the rhythm begins anew, with
// kFirstApproach.
//
// With a time constant tau: the base follows the newest command as a critically damped second-order system,
//
//   tau² x'' + 2 tau x' + (x - target) = 0,
//
// solved exactly over a tick for a target at rest. It lags behind a steady motion by 2 tau and does not overshoot.
// tau = 0, or tiny beside a tick: straight to the target.
//
// A speed limit caps the step of every tick. Orientation and spin follow alike; orientation takes the shortest way.
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
