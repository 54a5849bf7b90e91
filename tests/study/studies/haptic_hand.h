// SPDX-License-Identifier: GPL-3.0-or-later
// A hand with a task, on a handle that moves and turns, as a device of acus-haptic's session: it presses a tissue that
// never opens, or inserts the needle, holds, and pulls it back, or inserts it and turns it about the base. Goes by the
// session's clock, deterministic.
#pragma once

#include <functional>
#include <string>

#include "client/haptics/device.h"
#include "client/haptics/simulated_handle.h"

namespace acus {

enum class HapticTask { palpate, insert, turn };

// Where the hand means to be: phases one after the other, each of which ends when its condition holds.
class HandPlan {
 public:
  enum Phase {
    approach,
    press,
    hold_pressed,
    press_on,
    hold_pressed_on,
    insert,
    hold_inserted,
    pull,
    hold_pulled,
    tilt,
    hold_tilted,
    roll,
    hold_rolled,
    done
  };

  // `gap`: m, of the tip from the surface at the start; `puncture_force`: N, of which the hand presses a part.
  HandPlan(HapticTask task, double gap, double puncture_force)
      : task_(task), gap_(gap), puncture_force_(puncture_force) {}

  // One step later, with the force against the hand and the place of the handle (N, m).
  void step(double h, double force, double place);

  Phase phase() const { return phase_; }
  double since() const { return since_; }      // s, of this phase
  double place() const { return place_; }      // m, along the needle
  double tilt_angle() const { return tilt_; }  // rad, about the device's y
  double roll_angle() const { return roll_; }  // rad, about the needle
  // m/s and rad/s of these in this phase.
  double speed() const;
  double tilt_speed() const { return phase_ == tilt ? kTiltSpeed : 0; }
  double roll_speed() const { return phase_ == roll ? kRollSpeed : 0; }
  bool holds() const { return speed() == 0 && tilt_speed() == 0 && roll_speed() == 0 && phase_ != done; }

  static constexpr double kHold = 0.6;  // s

 private:
  static constexpr double kTilt = 0.05, kTiltSpeed = 0.1;  // rad, rad/s
  static constexpr double kRoll = 1, kRollSpeed = 2;       // likewise

  Phase next() const;
  bool ended(double force, double place) const;

  HapticTask task_;
  double gap_, puncture_force_;
  Phase phase_ = approach;
  double since_ = 0, place_ = 0, tilt_ = 0, roll_ = 0, began_at_ = 0;
};

class PlannedDevice : public haptics::Device {
 public:
  // `hand` of the translation; against rotation it is the same hand at a lever of kLever.
  PlannedDevice(const haptics::DeviceProperties& properties, const haptics::HandImpedance& hand, const HandPlan& plan,
                std::function<double()> clock);

  haptics::DeviceProperties open() override;
  Reading read() override;
  void write(const haptics::Wrench& wrench) override;
  void close() override { write({}); }

  const HandPlan& plan() const { return plan_; }
  haptics::Pose pose() const;  // true, not in steps of the encoder
  // J, most that the device gave the hand beyond what it had taken (SimulatedHandle::made), of both kinds of motion
  // together.
  double most_made() const { return most_made_; }
  // At every step of the handle.
  std::function<void()> on_step = [] {};

  static constexpr double kLever = 0.1;  // m, chosen: a hand's width

 private:
  haptics::DeviceProperties properties_;
  HandPlan plan_;
  std::function<double()> clock_;
  haptics::SimulatedHandle translation_, rotation_;
  haptics::Wrench rendered_;
  double began_ = 0, most_made_ = 0;
};

}  // namespace acus
