// SPDX-License-Identifier: GPL-3.0-or-later
// A hand on a haptic device on a needle in tissue, as users have them: the session of acus-haptic drives a real
// acus-server in lockstep, over a simulated network with delay, jitter and loss; the hand and its handle are simulated.
// The hand presses a tissue that never opens, inserts the needle into one that does, holds and pulls back; with a
// device that has torques it inserts the needle and turns it. Deterministic. With the kit (client/haptics), or without:
// then the device's pose goes to the server as it is, and the newest force that came is rendered.
#pragma once

#include <string>

#include "client/haptics/coupling.h"
#include "client/haptics/delay_line.h"
#include "client/haptics/simulated_hand.h"

namespace acus {

struct HapticSetting {
  double young_modulus = 1e4;  // Pa, of the tissue
  double rate = 1000;          // Hz, of the device
  haptics::LinkDelay network;  // both ways together, loss of each
  haptics::Grip grip = haptics::kGrips[1];
  double mass = 0.1;   // kg, of the device
  bool turns = false;  // a device with torques: the needle is inserted and turned
  bool kit = true;
};

struct HapticOutcome {
  double swing = 0;  // N, of the device's force in the second half of holds, from turn to turn, see haptic_run.cpp
  double twist = 0;  // N m, likewise of its torque
  double felt = 0;  // N/m, of the rendered force over the way of the handle, from one hold to a firmer one; of a device
                    // that turns N m/rad, of the torque against tilting
  double tissue = 0;         // N m/rad, of a device that turns: of the server's torque over the way of the base
  double held = 0;           // N or N m, at the device in the firmer hold,
  double wanted = 0;         // what the kit wanted to render there,
  double at_server = 0;      // and the server's own
  double made = 0;           // J, most that the device gave the hand beyond what it had taken
  double withheld = 0;       // J, that the controller kept from the hand
  double largest_force = 0;  // N, rendered
  bool punctured = false;
  double server_drop = 0;    // N, largest fall of the server's force from one sample to the next at the puncture,
  double puncture_drop = 0;  // N, and fall of the rendered force in that sample
  double puncture_felt = 0;  // N, most that was rendered in the last 50 ms before the puncture was heard of,
  double puncture_rise = 0;  // N, and most that was rendered beyond it in the 50 ms after
  double chatter = 0;        // N, root mean square of the rendered force above 30 Hz while the needle slides
};

// Above these a swing is a limit cycle.
inline constexpr double kCycle = 0.1;        // N
inline constexpr double kTwistCycle = 0.01;  // N m

// The device of the study.
haptics::DeviceProperties studied_device(const HapticSetting& setting);

// The stiffness that a passive device may have, without any network, or the tissue's own if that is less: what a felt
// stiffness is compared with. N/m, or N m/rad.
double felt_bound(const HapticSetting& setting, double tissue_stiffness);

// N, of the tissue that opens.
double puncture_force(double young_modulus);

// Of the tissue at the tip, felt at the base, as the hand presses: without device, delay or kit (N/m).
double pressed_stiffness(double young_modulus);

// Starts servers of its own. Throws what the session does.
HapticOutcome run_haptic(const HapticSetting& setting);

}  // namespace acus
