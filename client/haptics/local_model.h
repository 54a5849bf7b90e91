// SPDX-License-Identifier: MIT
// What a hand at the base of a needle feels around the base's place at one tick: what a message of the topic `haptics`
// says (message.h), whose fields protocol/README.md explains. World frame, SI units.
#pragma once

#include <array>
#include <cstdint>

#include "client/haptics/vectors.h"

namespace acus::haptics {

// What happens where the linear model ends.
enum class Limit { none, puncture, cutting, slip, contact };
inline constexpr std::array<const char*, 5> kLimitNames{"none", "puncture", "cutting", "slip", "contact"};

struct LocalModel {
  std::uint64_t epoch = 0;
  std::uint64_t tick = 0;
  double time = 0;        // s, simulation time
  std::uint64_t seq = 0;  // of the command in use
  double echo = 0;        // s, time stamp of that command, on the clock of its sender
  double age = 0;         // s of simulation time since that command came
  bool stale = false;     // no command came for too long; force and torque are on their ramp
  Pose base;              // after the tick; spin not applied
  double spin = 0;        // rad
  Wrench felt;            // N, N m about the base: what a hand at the base feels of a needle that stands still
  // d(force, torque)/d(translation, rotation vector of the base): N/m, N/rad, N m/m, N m/rad. What resists has a
  // negative diagonal.
  Matrix6 stiffness;
  // How far the base may go along its +x and -x until the needle as a whole gives way (m, 0 to 1). The force along x
  // does not grow beyond.
  double forward = 1, backward = 1;
  Limit forward_limit = Limit::none, backward_limit = Limit::none;
  // And how much the force along x changes on that way (N, >= 0); 0: not known.
  double forward_change = 0, backward_change = 0;
  Wrench in_air;  // N, N m about the base: what is felt beyond a backward limit of contact, as of the needle's weight

  // Nothing touches the needle.
  bool is_free() const { return forward_limit == Limit::none && backward_limit == Limit::none; }
  // N/m, >= 0, against a way along the base's x.
  double axial_stiffness() const;
  // The limits, from what the laws bear against a way ahead and back (N, >= 0): what bears nothing on the way back is
  // but touched, and what bears nothing either way is free.
  void put_limits(double forward_yield, double backward_yield, bool cuts);
};

}  // namespace acus::haptics
