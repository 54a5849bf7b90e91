// SPDX-License-Identifier: GPL-3.0-or-later
// Gauss-Seidel over the laws (Duriez et al. 2009, section 3, eq. 6): sweeps (sweep.h) until no law is violated by more
// than the tolerance.
//
// Departures from the paper: the bilateral rows are eliminated before (reduced_laws.h). And points that stick within
// one element are nearly dependent, where sweeps alone converge slowly; so after kDirectAfter sweeps the direct method goes
// on once from where the sweeps have left the rows (direct_laws.h) [after Silcowitz, Niebe, Erleben 2010, "Projected
// Gauss-Seidel subspace minimization"].
#pragma once

#include "server/engine/laws/solver/direct_laws.h"

namespace acus {

class GaussSeidel {
 public:
  static constexpr int kDirectAfter = 8;

  struct Counts {
    int sweeps = 0;
    DirectSteps direct;
  };

  explicit GaussSeidel(DirectLaws& direct) : direct_(direct) {}

  // Sweeps from the forces given until no law is violated by more than `tolerance` (N), `budget` is spent or the
  // violation is not a number.
  Counts solve(const LawSystem& system, double tolerance, const LawState& state, StepBudget& budget);

 private:
  DirectLaws& direct_;
};

}  // namespace acus
