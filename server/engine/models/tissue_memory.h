// SPDX-License-Identifier: GPL-3.0-or-later
// Stress that relaxes: a Prony series beside Hooke's law, per region,
//
//   sigma(t) = C (eps(t) + sum of g_i times the integral of e^(-(t - s)/tau_i) d eps(s)),
//
// eps the corotational strain, so that turning a body relaxes nothing. Strained at once tissue is 1 + sum g_i times as
// stiff as at rest, C is that of rest. A strain that is held gives (1 + sum g_i e^(-t/tau_i)) C eps. With z_i the
// strain to which a branch has crept, sigma = C (eps + sum g_i (eps - z_i)) and dz_i/dt = (eps - z_i)/tau_i. In a tick
//
//   z_i' = z_i + alpha_i (eps' - z_i),   alpha_i = 1 - e^(-h/tau_i),
//   sigma' = C (G eps' - sum g_i (1 - alpha_i) z_i),   G = 1 + sum g_i (1 - alpha_i):
//
// exact while a strain is held, of first order in h else. It is the gradient of a potential that is convex in eps', and
// of the same matrix as Hooke's law, K0 times G: the factor is made once. Branches never gain energy.
//
// With nodal pressures (nodal_pressure.h) the elements' own share relaxes; the mean pressure, nearly the whole answer
// to a change of volume, does not.
#pragma once

#include <vector>

#include "server/engine/models/tissue.h"

namespace acus {

// What does not change between ticks of h. Branches that a region lacks have g = 0.
struct TissueMemory {
  TissueMemory(const TissueModel& model, double h);

  int branches;                         // most of a region
  std::vector<double> stiffening;       // per tetrahedron: G
  std::vector<Octet> batch_stiffening;  // per batch, the same
  std::vector<Octet> given, taken;      // per batch and branch: g (1 - alpha), alpha
  double least_stiffening;

  MemoryArrays arrays(const std::vector<StrainBatch>& crept) const {
    return {branches, batch_stiffening.data(), given.data(), crept.data()};
  }
};

// Takes the strains at x into memory: crept <- z' from z = `before`, and adds to `forces` (3 x nodes, N) by what the
// elastic forces at x change, their rotations being as they are.
void relax(const TissueModel& model, const TissueMemory& memory, const Matrix3X& x, const ElementRotations& rotations,
           const std::vector<StrainBatch>& before, std::vector<StrainBatch>& crept, ElementScratch& scratch,
           Matrix3X& forces);

// Of the branches at x, z of the end of the tick before (J).
double memory_energy(const TissueModel& model, const TissueMemory& memory, const Matrix3X& x,
                     const ElementRotations& rotations, const std::vector<StrainBatch>& before);

}  // namespace acus
