// SPDX-License-Identifier: MIT
#include "client/haptics/devices/rate_control.h"

#include <algorithm>
#include <cmath>

namespace acus::haptics {

// From zero at the edge of the dead zone to one at full deflection.
double RateControl::outside_dead_zone(double deflection) const {
  const double beyond = std::max(std::abs(deflection) - speeds_.dead_zone, 0.0) / (1 - speeds_.dead_zone);
  return std::copysign(std::min(beyond, 1.0), deflection);
}

const Pose& RateControl::step(const Deflection& deflection, double now) {
  constexpr double kLongest = 0.1;  // s: after a longer silence the pose does not jump
  const double h = last_ < 0 ? 0 : std::clamp(now - last_, 0.0, kLongest);
  last_ = now;
  Vector6 way;
  for (int i = 0; i < 3; ++i) {
    way[i] = h * speeds_.translation * outside_dead_zone(deflection.translation[i]);
    way[i + 3] = h * speeds_.rotation * outside_dead_zone(deflection.rotation[i]);
  }
  pose_ = displaced(pose_, way);
  return pose_;
}

DeviceProperties without_force(double rate) {
  DeviceProperties properties;
  properties.rate = rate;
  properties.translation.largest_force = 0;
  properties.rotation.largest_force = 0;
  return properties;
}

}  // namespace acus::haptics
