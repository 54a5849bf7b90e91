// SPDX-License-Identifier: GPL-3.0-or-later
// Stress that relaxes: a Prony series beside Hooke's law, per region,
//
//   sigma(t) = C (eps(t) + sum of g_i times the integral of e^(-(t - s)/tau_i) d eps(s)).
//
// Strained at once tissue is 1 + sum g_i times as stiff as at rest, C is that of rest. A strain that is held gives
// (1 + sum g_i e^(-t/tau_i)) C eps. With z_i the strain to which a branch has crept, sigma = C (eps + sum g_i (eps -
// z_i)) and dz_i/dt = (eps - z_i)/tau_i. In a tick
//
//   z_i' = z_i + alpha_i (eps' - z_i),   alpha_i = 1 - e^(-h/tau_i),
//   sigma' = C (G eps' - sum g_i (1 - alpha_i) z_i),   G = 1 + sum g_i (1 - alpha_i):
//
// exact while a strain is held, of first order in h else. It is the gradient of a potential that is convex in eps', and
// branches never gain energy.
#pragma once

#include "server/engine/math/types.h"
#include "server/engine/models/element/material.h"

namespace acus {

// Of one material, in ticks of h (s). Branches that it lacks have g = alpha = 0.
using Branches = Eigen::Matrix<double, static_cast<int>(kMaxRelaxations), 1>;
struct RelaxationStep {
  RelaxationStep() = default;
  RelaxationStep(const Material& material, double h);

  double stiffening = 1;              // G
  Branches given = Branches::Zero();  // g (1 - alpha)
  Branches taken = Branches::Zero();  // alpha
};

}  // namespace acus
