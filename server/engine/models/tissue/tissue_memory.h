// SPDX-License-Identifier: GPL-3.0-or-later
// Elements whose stress relaxes (relaxation.h), eps being the corotational strain, so that turning a body relaxes
// nothing. The matrix is Hooke's, K0 times G: the factor is made once.
//
// With nodal pressures (nodal_pressure.h) the elements' own share relaxes; the mean pressure, nearly the whole answer
// to a change of volume, does not.
#pragma once

#include <vector>

#include "server/engine/models/element/relaxation.h"
#include "server/engine/models/tissue/tissue.h"

namespace acus {

// What does not change between ticks of h.
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
