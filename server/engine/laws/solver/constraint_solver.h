// SPDX-License-Identifier: GPL-3.0-or-later
// Stage 7: the forces at which every law holds on its line, delta = W lambda + delta_free. Bilateral rows are
// eliminated (reduced_laws.h); the others are solved
//
//   direct         by the pieces of their graphs (direct_laws.h), to kDirectEnd of force_scale(), in a bounded number
//                  of factorisations. Starts on the pieces that the rows pick at the forces of the last tick. Where the
//                  best answer is neither that good nor within the tolerance given Gauss-Seidel goes on from there;
//   gauss_seidel   by sweeps (gauss_seidel.h), to the tolerance given.
//
// One budget of steps bounds all that a call does, whatever the method: sweeps, picks and interior-point iterations.
// The residual is taken on the full W as it was given, after the bilateral rows have followed; where it is too large
// the elimination is repeated about the answer, kMaxRounds times at most, which mends what regularisation and rounding
// left over. The answer that violates the laws least is the one returned. Nothing depends on earlier calls, but for the
// forces that the caller hands in. Nothing allocates after construction.
#pragma once

#include "server/engine/laws/solver/gauss_seidel.h"
#include "server/engine/laws/solver/law_method.h"
#include "server/engine/laws/solver/reduced_laws.h"

namespace acus {

class ConstraintSolver {
 public:
  static constexpr double kDirectEnd = 1e-10;  // violation, as share of the largest force, see force_scale()
  static constexpr int kMaxRounds = 4;

  explicit ConstraintSolver(int capacity);
  ConstraintSolver(const ConstraintSolver&) = delete;  // parts refer to each other
  ConstraintSolver& operator=(const ConstraintSolver&) = delete;

  // W: symmetric (m/N), positive diagonal, rows x rows in its top left corner, rows <= capacity. delta_free (m) and
  // lambda (N) have one entry per law; lambda is the first guess; delta returns W lambda + delta_free. `max_steps`
  // bounds the steps of all kinds together; an answer converged if its residual is within the tolerance (N). Where one
  // of W or delta_free is not a number the forces are zero, without a step, and it has not converged.
  SolverResult solve(LawMethod method, Eigen::Ref<const MatrixX> W, std::span<const Law> laws,
                     std::span<const double> delta_free, int max_steps, double tolerance, std::span<double> lambda,
                     std::span<double> delta);

 private:
  template <class Inner, class Target>
  void solve_rounds(const LawSystem& full, const LawState& state, SolverResult& result, Target target, Inner inner);
  void solve_directly(const LawSystem& full, const LawState& state, StepBudget& budget, SolverResult& result);
  void solve_by_sweeps(const LawSystem& full, double tolerance, const LawState& state, StepBudget& budget,
                       SolverResult& result);

  DirectLaws direct_;
  GaussSeidel gauss_seidel_;
  ReducedLaws reduced_;
  std::vector<double> scale_;
  std::vector<double> trial_lambda_, trial_delta_;
};

}  // namespace acus
