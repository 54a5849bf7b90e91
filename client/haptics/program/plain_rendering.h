// SPDX-License-Identifier: MIT
// What a program without the kit does: the device's pose goes to the server as it is, and the server's newest force is
// rendered. For comparison (acus-haptic --no-kit); unstable in stiff tissue and over slow networks.
#pragma once

#include <cstdint>

#include "client/haptics/kit.h"
#include "client/haptics/limits.h"

namespace acus::haptics {

class PlainRendering {
 public:
  PlainRendering(const DeviceProperties& properties, const Workspace& workspace)
      : properties_(properties), registration_(workspace) {}

  void begin(const Pose& device, const Pose& base) {
    registration_.bring_together(device, base);
    device_ = device;
  }
  void take(const Wrench& at_base) { newest_ = at_base; }  // N, N m, world
  Kit::Answer step(const Pose& device) {
    given_ += dot(rendered_, device.position - device_.position);
    device_ = device;
    Kit::Answer answer;
    answer.base = registration_.base_of(device);
    answer.seq = ++seq_;
    answer.wanted = registration_.at_device(newest_);
    answer.on_hand = {limited(answer.wanted.force, properties_.translation.largest_force),
                      limited(answer.wanted.torque, properties_.rotation.largest_force)};
    rendered_ = answer.on_hand.force;
    return answer;
  }
  double given() const { return given_; }  // J, net, that the rendered forces brought to the device

 private:
  DeviceProperties properties_;
  Registration registration_;
  Wrench newest_;
  Pose device_;
  Vector3 rendered_;
  double given_ = 0;
  std::uint64_t seq_ = 0;
};

}  // namespace acus::haptics
