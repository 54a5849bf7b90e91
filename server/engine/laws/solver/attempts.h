// SPDX-License-Identifier: GPL-3.0-or-later
// The ways to solve laws without bilateral rows, as lists of attempts. Each attempt continues from the forces of the
// one before. A list ends where an attempt finds its end met, where the budget is spent, or after its last attempt.
//
//   direct         two sweeps (sweep.h) move the forces of the last tick onto this tick's graphs: pivoting from single
//                  rows' steps instead picks wrongly for many more rows where a needle slows down. Pivoting
//                  (pivoting.h) needs a few picks where the rows can be distinguished; the interior-point method
//                  (interior_point.h) needs one or two dozen iterations whatever the rows are, but moves no contact
//                  with friction. So the two take turns.
//   gauss_seidel   sweeps to the tolerance (Duriez et al. 2009, section 3, eq. 6). Departure from the paper: points
//   that
//                  stick within one element are nearly dependent, where sweeps converge slowly; so after kFirstSweeps
//                  the direct attempts are made once [after Silcowitz, Niebe, Erleben 2010, "Projected Gauss-Seidel
//                  subspace minimization"].
#pragma once

#include <limits>
#include <span>
#include <vector>

#include "server/engine/laws/solver/interior_point.h"
#include "server/engine/laws/solver/law_method.h"
#include "server/engine/laws/solver/pivoting.h"

namespace acus {

struct Attempt {
  enum class By { sweeps, pivoting, interior_point } by = By::sweeps;
  enum class To { rounding, tolerance } to = To::rounding;  // the violation at which it ends
  int sweeps = 0;                                           // at most
};

inline constexpr double kRoundingEnd = 1e-11;  // violation, as share of the largest force, see force_scale()
inline constexpr int kFirstSweeps = 8;

inline constexpr Attempt kDirect[]{
    {Attempt::By::sweeps, Attempt::To::rounding, 2},
    {Attempt::By::pivoting},
    {Attempt::By::interior_point},
    {Attempt::By::pivoting},
    {Attempt::By::interior_point},
};
inline constexpr Attempt kGaussSeidel[]{
    {Attempt::By::sweeps, Attempt::To::tolerance, kFirstSweeps},
    {Attempt::By::sweeps, Attempt::To::rounding, 2},
    {Attempt::By::pivoting},
    {Attempt::By::interior_point},
    {Attempt::By::pivoting},
    {Attempt::By::interior_point},
    {Attempt::By::sweeps, Attempt::To::tolerance, std::numeric_limits<int>::max()},
};

class Attempts {
 public:
  explicit Attempts(int capacity);
  Attempts(const Attempts&) = delete;
  Attempts& operator=(const Attempts&) = delete;

  // Starts from the forces given and leaves better ones, with their displacements. Attempts to rounding end at
  // kRoundingEnd or at the tolerance (N), what is less; where laws have curves, at the tolerance from the first pick
  // on, since each more of Newton's steps costs as much as all others of a usual tick. Adds steps, and sweeps to the
  // tolerance, to `result`. Where the violation is not a number it ends.
  // `room`: rows² numbers at least.
  void run(std::span<const Attempt> attempts, double tolerance, const LawSystem& system, const LawState& state,
           std::span<double> room, StepBudget& budget, SolverResult& result);

 private:
  // These return the violation (N) that is left. Sweeps to rounding do not look: infinity.
  double sweep_up_to(const Attempt& attempt, double end, const LawSystem& system, const LawState& state,
                     StepBudget& budget, SolverResult& result);
  double try_interior_point(double residual, const LawSystem& system, const LawState& state, StepBudget& budget,
                            SolverResult& result);

  std::span<double> room_;  // of the matrices of both
  Pivoting pivoting_;
  InteriorPoint interior_point_;
  std::vector<double> trial_lambda_, trial_delta_;
};

}  // namespace acus
