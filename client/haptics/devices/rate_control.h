// SPDX-License-Identifier: MIT
// A handle that does not move far but is pushed, as a joystick: what is pushed becomes a speed, and the pose is its
// sum.
#pragma once

#include "client/haptics/coupling.h"
#include "client/haptics/vectors.h"

namespace acus::haptics {

struct Deflection {
  Vector3 translation;  // -1 to 1 each
  Vector3 rotation;     // -1 to 1 each
};

class RateControl {
 public:
  struct Speeds {
    double translation = 0.03;  // m/s at full deflection
    double rotation = 0.5;      // rad/s
    double dead_zone = 0.1;     // -, of the deflection, that counts as none
  };

  RateControl() = default;
  explicit RateControl(const Speeds& speeds) : speeds_(speeds) {}

  // The pose after the deflection has lasted until `now` (s) from the last call on; the first call begins.
  const Pose& step(const Deflection& deflection, double now);

 private:
  double outside_dead_zone(double deflection) const;

  Speeds speeds_;
  Pose pose_;
  double last_ = -1;
};

// Of a device that renders no force.
DeviceProperties without_force(double rate);

}  // namespace acus::haptics
