// SPDX-License-Identifier: MIT
// The handle of a haptic device with a hand on it, simulated: mass, damping, Coulomb friction, an encoder with steps, a
// force that saturates and comes late. Translation only; the handle does not turn. Deterministic: time goes on when
// advance() says so.
#pragma once

#include "client/haptics/coupling.h"
#include "client/haptics/delay_line.h"
#include "client/haptics/simulated_hand.h"
#include "client/haptics/vectors.h"

namespace acus::haptics {

struct SimulatedHandleProperties {
  AxisProperties axis;  // alike in all directions
  LinkDelay delay;      // from a written force to the force that acts
  HandImpedance hand;
};

class SimulatedHandle {
 public:
  explicit SimulatedHandle(const SimulatedHandleProperties& properties);

  // Where the hand means to be from now on, and how fast it means to move there (m, m/s).
  void mean(const Vector3& position, const Vector3& velocity);
  // A force to act from now on, later by the delay (N).
  void write(const Vector3& force);
  // Time goes on, in steps of kStep at most.
  void advance(double seconds);

  Vector3 measured() const;            // m, as the encoder tells it
  double now() const { return now_; }  // s
  const Vector3& position() const { return position_; }
  const Vector3& velocity() const { return velocity_; }
  const Vector3& acting() const { return acting_; }  // N, force of the device on the handle
  // J since the start, net: what the device's force brought, beyond what the handle's own damping ate of it. Above zero
  // the device as a whole, with all that is behind it, gave the hand more than it ever took.
  double made() const { return made_; }
  double most_made() const { return most_made_; }

  static constexpr double kStep = 50e-6;  // s

 private:
  void step(double h);

  SimulatedHandleProperties properties_;
  DelayLine<Vector3> link_;
  double mass_;
  double now_ = 0;
  Vector3 position_, velocity_, acting_, meant_, meant_velocity_;
  double made_ = 0, most_made_ = 0;
};

}  // namespace acus::haptics
