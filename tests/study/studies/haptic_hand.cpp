// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/study/studies/haptic_hand.h"

#include <algorithm>
#include <utility>

namespace acus {

void HandPlan::step(double h, double force, double place) {
  since_ += h;
  place_ += h * speed();
  tilt_ += h * tilt_speed();
  roll_ += h * roll_speed();
  if (!ended(force, place)) return;
  phase_ = next();
  since_ = 0;
  began_at_ = place_;
}

double HandPlan::speed() const {
  switch (phase_) {
    case approach:
    case insert:
      return 0.05;
    case press:
    case press_on:
      return 0.02;
    case pull:
      return -0.05;
    default:
      return 0;
  }
}

HandPlan::Phase HandPlan::next() const {
  if (phase_ == approach && task_ != HapticTask::palpate) return insert;
  if (phase_ == hold_inserted && task_ == HapticTask::turn) return tilt;
  if (phase_ == hold_pressed_on || phase_ == hold_pulled) return done;
  return static_cast<Phase>(phase_ + 1);
}

bool HandPlan::ended(double force, double place) const {
  switch (phase_) {
    case approach:
      return place_ > gap_ - 0.5e-3;
    case press:
      return force > 0.2 * puncture_force_ || place_ > gap_ + 0.03;
    case press_on:
      return place_ > began_at_ + 2e-3 && (force > 0.6 * puncture_force_ || place_ > gap_ + 0.06);
    case insert:
      return place > gap_ + 0.02 || place_ > gap_ + 0.06;
    case pull:
      return place_ < began_at_ - 8e-3;
    case tilt:
      return tilt_ > kTilt;
    case roll:
      return roll_ > kRoll;
    case done:
      return false;
    default:
      return since_ > kHold;
  }
}

namespace {

haptics::HandImpedance at_lever(haptics::HandImpedance hand) {
  constexpr double kSquared = PlannedDevice::kLever * PlannedDevice::kLever;
  return {hand.mass * kSquared, hand.damping * kSquared, hand.stiffness * kSquared};
}

}  // namespace

PlannedDevice::PlannedDevice(const haptics::DeviceProperties& properties, const haptics::HandImpedance& hand,
                             const HandPlan& plan, std::function<double()> clock)
    : properties_(properties),
      plan_(plan),
      clock_(std::move(clock)),
      translation_({properties.translation, {}, hand}),
      rotation_({properties.rotation, {}, at_lever(hand)}) {}

haptics::DeviceProperties PlannedDevice::open() {
  began_ = clock_();
  return properties_;
}

haptics::Device::Reading PlannedDevice::read() {
  constexpr double kStep = haptics::SimulatedHandle::kStep;
  const double until = clock_() - began_;
  while (translation_.now() < until - kStep / 2) {
    translation_.mean({{plan_.place(), 0, 0}}, {{plan_.speed(), 0, 0}});
    rotation_.mean({{plan_.roll_angle(), plan_.tilt_angle(), 0}}, {{plan_.roll_speed(), plan_.tilt_speed(), 0}});
    translation_.advance(kStep);
    rotation_.advance(kStep);
    most_made_ = std::max(most_made_, translation_.made() + rotation_.made());
    on_step();
    plan_.step(kStep, -rendered_.force[0], translation_.position()[0]);
  }
  return {{translation_.measured(), haptics::rotation(rotation_.measured())}, false};
}

void PlannedDevice::write(const haptics::Wrench& wrench) {
  rendered_ = wrench;
  translation_.write(wrench.force);
  rotation_.write(wrench.torque);
}

haptics::Pose PlannedDevice::pose() const { return {translation_.position(), haptics::rotation(rotation_.position())}; }

}  // namespace acus
