// SPDX-License-Identifier: MIT
#include "client/haptics/simulated_handle.h"

#include <algorithm>
#include <cmath>

#include "client/haptics/limits.h"

namespace acus::haptics {

SimulatedHandle::SimulatedHandle(const SimulatedHandleProperties& properties)
    : properties_(properties), link_(properties.delay), mass_(properties.axis.mass + properties.hand.mass) {}

void SimulatedHandle::mean(const Vector3& position, const Vector3& velocity) {
  meant_ = position;
  meant_velocity_ = velocity;
}

void SimulatedHandle::write(const Vector3& force) { link_.send(now_, limited(force, properties_.axis.largest_force)); }

void SimulatedHandle::advance(double seconds) {
  const int steps = static_cast<int>(std::ceil(seconds / kStep - 1e-9));
  for (int i = 0; i < steps; ++i) {
    while (const auto force = link_.receive(now_)) acting_ = *force;
    step(seconds / steps);
  }
}

// Implicit in damping and stiffness, so that no hand is too stiff for the step; friction takes up to its share of the
// velocity and never turns it.
void SimulatedHandle::step(double h) {
  const HandImpedance& hand = properties_.hand;
  const double damping = properties_.axis.damping + hand.damping;
  const Vector3 pull = acting_ + hand.stiffness * (meant_ - position_) + hand.damping * meant_velocity_;
  const double inertia = mass_ + h * damping + h * h * hand.stiffness;
  Vector3 next = (mass_ * velocity_ + h * pull) * (1 / inertia);
  const double speed = norm(next), taken = h * properties_.axis.friction / inertia;
  next = speed > taken ? (1 - taken / speed) * next : Vector3{};
  const Vector3 way = h * next;
  made_ += dot(acting_, way) - properties_.axis.damping * dot(next, way) - properties_.axis.friction * norm(way);
  most_made_ = std::max(most_made_, made_);
  velocity_ = next;
  position_ += way;
  now_ += h;
}

Vector3 SimulatedHandle::measured() const {
  const double step = properties_.axis.resolution;
  if (step == 0) return position_;
  Vector3 rounded;
  for (int i = 0; i < 3; ++i) rounded[i] = step * std::round(position_[i] / step);
  return rounded;
}

}  // namespace acus::haptics
