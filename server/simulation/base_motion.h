// SPDX-License-Identifier: GPL-3.0-or-later
// How a needle's base, or a guide, follows its commands. Commands arrive in steps, at the client's rate and with the
// network's jitter; the base follows the newest one as a critically damped second-order system of time constant tau,
//
//   tau² x'' + 2 tau x' + (x - target) = 0,
//
// solved exactly over a tick for a target that stands still in it, so the motion does not depend on h but through the
// sampling of the targets. It comes to rest at the target without overshoot and lags behind a steady motion by 2 tau.
// tau = 0, or so small that a tick lasts for ever beside it: straight to the target. A speed limit caps the step of every
// tick. Orientation and spin follow alike; orientation takes the shortest way.
#pragma once

#include <cstdint>
#include <optional>

#include "server/scene/scene.h"

namespace acus {

// Where a base shall go. Fields that are absent keep their last value.
struct Command {
  std::uint64_t seq = 0;
  std::optional<Pose> pose;    // world, within kMaxPosition, unit orientation without spin
  std::optional<double> spin;  // rad, within kMaxSpin, continuous over many turns, about the needle's +x axis
};

// Finite, within the workspace, of unit orientation.
bool in_range(const Command& command);
// `pending` is replaced but for the fields that `newer` leaves out.
void merge(std::optional<Command>& pending, const Command& newer);

// Constant after loading.
struct BaseLimits {
  double tau = 0;                // s
  double max_speed = 0;          // m/s
  double max_angular_speed = 0;  // rad/s
  double max_spin_speed = 0;     // rad/s
};
BaseLimits base_limits(const Needle& parameters);
BaseLimits base_limits(const Guide& parameters);  // one that does not spin

struct BaseState {
  Pose pose, target;                            // without spin
  double spin = 0, target_spin = 0;             // rad
  Vector3 velocity = Vector3::Zero();           // m/s
  Vector3 angular_velocity = Vector3::Zero();   // rad/s, world
  double spin_velocity = 0;                     // rad/s
  std::uint64_t command_seq = 0;                // of the command in use, 0 before the first
  std::uint64_t command_tick = 0;               // that took it in

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
  }
};

// At rest, without a command.
BaseState base_at(const Pose& pose);

// A command that brings the base to rest where it comes to by itself, wherever it was going.
Command come_to_rest(const BaseLimits& limits, const BaseState& base);

// The base one tick (h, s) later, on its way to the newest command, if there is one.
BaseState follow(const BaseLimits& limits, double h, const BaseState& base, const std::optional<Command>& newest,
                 std::uint64_t tick);

}  // namespace acus
