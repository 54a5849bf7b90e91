// SPDX-License-Identifier: GPL-3.0-or-later
// Where a needle's base, or a guide, is and is going, and what bounds its motion, which tick/base_motion.h describes.
#pragma once

#include <cmath>
#include <cstdint>
#include <optional>

#include "server/engine/scene/scene.h"

namespace acus {

// Where a base shall go. Fields that are absent keep their last value.
struct Command {
  std::uint64_t seq = 0;
  std::optional<Pose> pose;    // world, within kMaxPosition, unit orientation without spin
  std::optional<double> spin;  // rad, within kMaxSpin, continuous over many turns, about the needle's +x axis
};

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
  Pose pose, target;                           // without spin
  double spin = 0, target_spin = 0;            // rad
  Vector3 velocity = Vector3::Zero();          // m/s
  Vector3 angular_velocity = Vector3::Zero();  // rad/s, world
  double spin_velocity = 0;                    // rad/s
  std::uint64_t command_seq = 0;               // of the command in use, 0 before the first
  std::uint64_t command_tick = 0;              // that took it in
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

// At rest, without a command.
BaseState base_at(const Pose& pose);

}  // namespace acus
