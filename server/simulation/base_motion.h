// SPDX-License-Identifier: GPL-3.0-or-later
// How a needle's base follows its commands. Commands arrive in steps, at the client's rate and with the network's
// jitter; the base follows the newest one as a critically damped second-order system of time constant tau,
//
//   tau² x'' + 2 tau x' + (x - target) = 0,
//
// solved exactly over a tick for a target that stands still in it, so the motion does not depend on h but through the
// sampling of the targets. It comes to rest at the target without overshoot and lags behind a steady motion by 2 tau.
// tau = 0, or so small that a tick lasts for ever beside it: straight to the target. A speed limit caps the step of every tick. Orientation and spin follow alike;
// orientation takes the shortest way.
#pragma once

#include <cstdint>
#include <optional>

#include "server/simulation/simulation.h"

namespace acus {

class BaseMotion {
 public:
  BaseMotion(const Needle& parameters, double h);
  BaseMotion(const Guide& parameters, double h);  // a guide moves like a base that does not spin

  void reset();
  // Replaces the pending command but for the fields that the new one leaves out. False, and nothing changes, if it is
  // out of range or not finite.
  bool command(const Command& command);

  // One tick; takes the pending command in first. Returns the base's pose with the spin applied.
  Pose advance(std::uint64_t tick);

  const Pose& pose() const { return pose_; }  // without spin
  double spin() const { return spin_; }       // rad
  std::uint64_t command_seq() const { return seq_; }
  std::uint64_t command_tick() const { return command_tick_; }

 private:
  Pose start_;
  double tau_;                                                    // s
  double max_speed_, max_angular_speed_, max_spin_speed_;         // m/s, rad/s, rad/s
  double h_;
  std::optional<Command> pending_;
  Pose target_, pose_;
  double target_spin_ = 0, spin_ = 0;
  Vector3 velocity_ = Vector3::Zero();          // m/s
  Vector3 angular_velocity_ = Vector3::Zero();  // rad/s, world
  double spin_velocity_ = 0;                    // rad/s
  std::uint64_t seq_ = 0, command_tick_ = 0;
};

}  // namespace acus
