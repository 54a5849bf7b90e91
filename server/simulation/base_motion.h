// SPDX-License-Identifier: GPL-3.0-or-later
// How a needle's base, or a guide, follows its commands. Commands arrive in steps, at the client's rate and with the
// network's jitter. Two ways to go on between them:
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

#include <cmath>
#include <cstdint>
#include <optional>

#include "server/scene/scene.h"

namespace acus {

inline constexpr double kPause = 0.1;            // s without a command, after which their rhythm is forgotten
inline constexpr double kFirstApproach = 10e-3;  // s to a command that follows no other

// Where a base shall go. Fields that are absent keep their last value.
struct Command {
  std::uint64_t seq = 0;
  std::optional<Pose> pose;    // world, within kMaxPosition, unit orientation without spin
  std::optional<double> spin;  // rad, within kMaxSpin, continuous over many turns, about the needle's +x axis
};

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

// Constant after loading.
struct BaseLimits {
  std::optional<double> tau;     // s; none: by the commands' rhythm
  double max_speed = 0;          // m/s
  double max_angular_speed = 0;  // rad/s
  double max_spin_speed = 0;     // rad/s
};
BaseLimits base_limits(const Needle& parameters);
BaseLimits base_limits(const Guide& parameters);  // one that does not spin

// When commands come, in ticks.
struct CommandRhythm {
  double interval = 1, deviation = 0;  // between two of them, means of late
  std::uint64_t commands = 0;          // since the last pause
  std::uint64_t left = 0;              // until the base is where the newest one wants it

  bool is_finite() const { return std::isfinite(interval) && std::isfinite(deviation); }

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("interval", self.interval);
    visit("deviation", self.deviation);
    visit("commands", self.commands);
    visit("left", self.left);
  }
};

struct BaseState {
  Pose pose, target;                            // without spin
  double spin = 0, target_spin = 0;             // rad
  Vector3 velocity = Vector3::Zero();           // m/s
  Vector3 angular_velocity = Vector3::Zero();   // rad/s, world
  double spin_velocity = 0;                     // rad/s
  std::uint64_t command_seq = 0;                // of the command in use, 0 before the first
  std::uint64_t command_tick = 0;               // that took it in
  CommandRhythm rhythm;

  // With the spin applied.
  Pose spun_pose() const;
  bool is_finite() const;

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("pose", self.pose);
    visit("target", self.target);
    visit("spin", self.spin);
    visit("target_spin", self.target_spin);
    visit("velocity", self.velocity);
    visit("angular_velocity", self.angular_velocity);
    visit("spin_velocity", self.spin_velocity);
    visit("command_seq", self.command_seq);
    visit("command_tick", self.command_tick);
    visit("rhythm", self.rhythm);
  }
};

// Whether it goes as fast as it may.
bool at_speed_limit(const BaseLimits& limits, const BaseState& base);

// At rest, without a command.
BaseState base_at(const Pose& pose);

// A command that brings the base to rest where it comes to by itself, wherever it was going.
Command come_to_rest(const BaseLimits& limits, const BaseState& base);

// The base one tick (h, s) later, on its way to the newest command, if there is one.
BaseState follow(const BaseLimits& limits, double h, const BaseState& base, const std::optional<Command>& newest,
                 std::uint64_t tick);

}  // namespace acus
