// SPDX-License-Identifier: MIT
// Where a device's workspace lies in the world: its axes turned, its motion scaled, its origin moved by a clutch.
//
//   base = base_at + scale R (x - x_at),   orientation = R (q q_at^-1) R^-1 orientation_at
//
// (x, q) is the device's pose, R turns its axes into the world's. What the hand feels goes the other way, in a scale of
// its own: force R^T F force_scale, torque R^T tau force_scale/scale, so that both have the same share of the power at
// the needle. `at` is where both were brought together last. A clutch parts them: the needle rests while the device
// moves to another place of its workspace.
#pragma once

#include "client/haptics/vectors.h"

namespace acus::haptics {

struct Workspace {
  Quaternion world_from_device;  // R
  double scale = 1;              // -, > 0: way of the needle over way of the device
  double force_scale = 1;        // -, > 0: force at the device over force at the needle
};

class Registration {
 public:
  explicit Registration(const Workspace& workspace = {}) : workspace_(workspace) {}

  // From now on the device's pose is this pose of the base.
  void bring_together(const Pose& device, const Pose& base) { device_at_ = device, base_at_ = base; }

  Pose base_of(const Pose& device) const;         // world
  Wrench at_device(const Wrench& at_base) const;  // device frame
  const Workspace& workspace() const { return workspace_; }
  double torque_scale() const { return workspace_.force_scale / workspace_.scale; }

 private:
  Workspace workspace_;
  Pose device_at_, base_at_;
};

}  // namespace acus::haptics
