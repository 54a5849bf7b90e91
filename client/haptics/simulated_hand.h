// SPDX-License-Identifier: MIT
// A hand on a handle: a mass that moves with it, and a spring and damper to where the hand means to be,
//
//   F = k (x_meant - x) + b (v_meant - v),
//
// the second-order impedance that Hogan 1989 (IEEE ICRA, "Controlling impedance at the man/machine interface") argues a
// hand looks like from a machine. Figures:
//
//   relaxed     0.554 kg, 6.45 N s/m, 135 N/m: an arm that holds its posture at a haptic device, one measured trial of
//   van
//               Beek, Bergmann Tiest, Mugge and Kappers 2015, Scientific Reports 5:18004, fig. 3
//   fingertips  no mass, 5 N s/m, 100 N/m: chosen, the lightest hand here; without mass nothing but the handle's own
//               stands against the loop's force
//   firm        0.554 kg, 20 N s/m, 600 N/m: chosen. Damping and stiffness grow with the force of the grip (Hasser and
//               Cutkosky 2002, Haptics Symposium, on a pinched knob); three and four times the relaxed figures
#pragma once

#include <array>

namespace acus::haptics {

struct HandImpedance {
  double mass = 0.554;     // kg, >= 0
  double damping = 6.45;   // N s/m, >= 0
  double stiffness = 135;  // N/m, >= 0
};

struct Grip {
  const char* name;
  HandImpedance hand;
};

inline constexpr std::array<Grip, 3> kGrips{Grip{"fingertips", {0, 5, 100}}, Grip{"relaxed", {0.554, 6.45, 135}},
                                            Grip{"firm", {0.554, 20, 600}}};

}  // namespace acus::haptics
