// SPDX-License-Identifier: GPL-3.0-or-later
// What tissue and needle are made of, as a scene gives it.
#pragma once

#include <optional>
#include <vector>

namespace acus {

// A branch of a Prony series: so many times Young's modulus beside it, lost in this time.
struct Relaxation {
  double ratio = 0.5;  // g (-), >= 0
  double time = 1;     // tau (s), > 0
};
inline constexpr std::size_t kMaxRelaxations = 4;

// Hooke's law with Rayleigh damping B = rayleigh_mass M + rayleigh_stiffness K.
struct Material {
  double young_modulus = 10e3;       // Pa, > 0
  double poisson_ratio = 0.45;       // -, [0, 0.5)
  double density = 1000;             // kg/m^3, > 0
  double rayleigh_mass = 0;          // 1/s, >= 0
  double rayleigh_stiffness = 0.01;  // s, >= 0
  std::vector<Relaxation> relaxation{};  // of tissue alone, see tissue_memory.h
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
