// SPDX-License-Identifier: GPL-3.0-or-later
// What tissue and needle are made of, as a scene gives it.
#pragma once

#include <optional>

namespace acus {

// Hooke's law with Rayleigh damping B = rayleigh_mass M + rayleigh_stiffness K.
struct Material {
  double young_modulus = 10e3;       // Pa, > 0
  double poisson_ratio = 0.45;       // -, [0, 0.5)
  double density = 1000;             // kg/m^3, > 0
  double rayleigh_mass = 0;          // 1/s, >= 0
  double rayleigh_stiffness = 0.01;  // s, >= 0
};

// A needle's body: a tube of circular section, straight or with an end that is bent to an arc.
struct NeedleBody {
  double length = 0.15;          // m, > 0
  int beams = 50;                // 1 to 1000
  double outer_diameter = 1e-3;  // m, > 0
  double inner_diameter = 0;     // m, [0, outer_diameter)
  double curvature = 0;          // 1/m, of the unloaded needle's end; positive bends it from +x towards +y
  std::optional<double> curved_length;  // m, (0, length], from the tip; absent: the whole needle
  Material material{200e9, 0.3, 7800, 0, 1e-3};
};

// What holds a needle's base to where it is told to be (held_base.h).
struct BaseHold {
  double stiffness = 1000;        // k (N/m), > 0
  double damping = 5;             // c (N s/m), >= 0
  double angular_stiffness = 10;  // k_r (N m/rad), > 0
  double angular_damping = 0.05;  // c_r (N m s/rad), >= 0
};

}  // namespace acus
