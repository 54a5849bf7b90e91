// SPDX-License-Identifier: MIT
#include "client/haptics/program/force_model.h"

#include <algorithm>
#include <cmath>

namespace acus::haptics {

double ForceModel::secant(const LocalModel& model) {
  const Vector3 axis = model.base.orientation * Vector3{{1, 0, 0}};
  if (count_ == kTicks) {
    const Past& then = past_[static_cast<std::size_t>(next_)];
    const double way = dot(axis, model.base.position - then.position);
    const double change = dot(axis, model.felt.force - then.force);
    // A force that does not grow against the way slides or yields; what it stuck with is kept.
    if (std::abs(way) > kShortest && change * way < 0) stiffness_ = std::min(-change / way, kStiffest);
  }
  past_[static_cast<std::size_t>(next_)] = {model.base.position, model.felt.force};
  next_ = (next_ + 1) % kTicks;
  count_ = std::min(count_ + 1, kTicks);
  return stiffness_;
}

LocalModel ForceModel::of(const protocol::Force& force) {
  LocalModel model = tick_of(force);
  model.base = pose_of(force.commanded_position, force.commanded_orientation);
  model.felt = {{force.haptic_force}, {force.haptic_torque}};
  if (force.phase == protocol::Phase::free) {
    count_ = 0;
    stiffness_ = 0;
    return model;
  }
  model.forward_limit = model.backward_limit = Limit::slip;  // somewhere
  const double stiffness = secant(model);
  if (!(stiffness > 0)) return model;
  const Vector3 axis = model.base.orientation * Vector3{{1, 0, 0}};
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) model.stiffness(i, j) = -stiffness * axis[i] * axis[j];
  if (force.phase == protocol::Phase::contact) {
    model.forward_limit = Limit::puncture;
    model.backward = std::clamp(-dot(axis, model.felt.force) / stiffness, 0.0, 1.0);
    model.backward_limit = Limit::contact;
  }
  return model;
}

}  // namespace acus::haptics
