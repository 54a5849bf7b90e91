// SPDX-License-Identifier: GPL-3.0-or-later
// The direct solver of laws without bilateral rows. kSweeps sweeps bring the forces of the last tick onto this tick's
// graphs, which tells the pieces that they stand on: with the steps of single rows from the same forces in place of the
// sweeps many more rows pick wrongly where a needle slows down. From there on pivoting (pivoting.h), which needs a few
// picks where the rows can be told apart, and where that gives up the interior-point method (interior_point.h), which
// needs a dozen or two iterations whatever the rows are. A contact with friction moves in pivoting alone, so then the
// two take turns. At most kMaxTurns of each. Where the violation is not a number nothing is tried.
#pragma once

#include "server/engine/laws/solver/interior_point.h"
#include "server/engine/laws/solver/law_method.h"
#include "server/engine/laws/solver/pivoting.h"

namespace acus {

class DirectLaws {
 public:
  static constexpr double kTurnsEnd = 1e-11;  // violation, as share of the largest force, see force_scale()
  static constexpr int kSweeps = 2;
  static constexpr int kMaxTurns = 2;

  explicit DirectLaws(int capacity);

  // Starts from the forces given; leaves the ones that violate the laws least, these or better ones, and their
  // displacements. Takes its steps from `budget`, the sweeps among them.
  DirectSteps solve(const LawSystem& system, const LawState& state, StepBudget& budget);

 private:
  Pivoting pivoting_;
  InteriorPoint interior_point_;
  std::vector<double> trial_lambda_, trial_delta_;
};

}  // namespace acus
