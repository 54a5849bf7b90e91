// SPDX-License-Identifier: GPL-3.0-or-later
// A hand on a haptic device on a needle in tissue, all simulated in one process and in simulation time: the server's
// ticks, the device's samples, the delay between them, and a hand that presses a tissue which never opens, then inserts
// the needle into one that does, holds, and pulls back. Deterministic. With the kit (client/haptics), or without: then
// the device's pose goes to the server as it is, and the newest force that came is rendered.
#pragma once

#include <string>

#include "client/haptics/coupling.h"
#include "client/haptics/simulated_hand.h"

namespace acus {

struct HapticSetting {
  double young_modulus = 1e4;  // Pa, of the tissue
  double rate = 1000;          // Hz, of the device
  double delay = 0;            // s, of the network, both ways together
  haptics::Grip grip = haptics::kGrips[1];
  bool kit = true;
};

struct HapticOutcome {
  double swing = 0;          // N, of the device's force at the end of holds, from turn to turn, see haptic_run.cpp
  double felt = 0;           // N/m, of the rendered force over the way of the handle, from one hold to a firmer one
  double made = 0;           // J, most that the device gave the hand beyond what it had taken (SimulatedHandle::made)
  double withheld = 0;       // J, that the controller took out
  double largest_force = 0;  // N, rendered
  bool punctured = false;
  double server_drop = 0;    // N, largest fall of the server's force from one sample to the next at the puncture,
  double puncture_drop = 0;  // N, and fall of the rendered force in that sample
  double chatter = 0;        // N, root mean square of the rendered force above 30 Hz while the needle slides
};

// Above this a swing is a limit cycle.
inline constexpr double kCycle = 0.1;  // N

// The device of the study: haptics::DeviceProperties with this rate.
haptics::DeviceProperties studied_device(double rate);

// Smaller of the bound of Colgate and Schenkel for the device, with the delay of the network within the loop, and the
// tissue's own stiffness (N/m): what a felt stiffness is compared with.
double felt_bound(const HapticSetting& setting, double tissue_stiffness);

// Of the tissue at the tip, felt at the base, as the hand presses: without device, delay or kit (N/m).
double pressed_stiffness(double young_modulus);

HapticOutcome run_haptic(const HapticSetting& setting);

}  // namespace acus
