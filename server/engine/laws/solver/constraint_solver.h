// SPDX-License-Identifier: GPL-3.0-or-later
// Stage 7: the forces at which every law holds on its line, delta = W lambda + delta_free. Bilateral rows are
// eliminated (reduced_laws.h); the others are solved by a list of attempts (attempts.h):
//
//   direct         to kDirectEnd of force_scale(); where the best answer is neither that good nor within the tolerance
//                  given, the attempts of gauss_seidel continue from it;
//   gauss_seidel   to the tolerance given.
//
// One budget of steps and work bounds a call: sweeps, picks and interior-point iterations. The residual is taken on the
// full W, after the bilateral rows have followed. Where it is too large the elimination is repeated about the answer,
// kMaxRounds times at most, which removes what regularisation and rounding left. The answer that violates the laws
// least is returned. Nothing depends on earlier calls, but for the forces that the caller hands in. Nothing allocates
// after construction.
#pragma once

#include <algorithm>

#include "server/engine/laws/solver/attempts.h"
#include "server/engine/laws/solver/law_method.h"
#include "server/engine/laws/solver/reduced_laws.h"

namespace acus {

class ConstraintSolver {
 public:
  static constexpr double kDirectEnd = 1e-10;  // violation, as share of the largest force, see force_scale()
  static constexpr int kMaxRounds = 4;

  explicit ConstraintSolver(int capacity) : ConstraintSolver(capacity, 2 * numbers(capacity)) {}
  // With so many numbers of room for matrices, which bounds systems, too: see fits().
  ConstraintSolver(int capacity, std::size_t room);
  ConstraintSolver(const ConstraintSolver&) = delete;
  ConstraintSolver& operator=(const ConstraintSolver&) = delete;

  // Of a square matrix.
  static constexpr std::size_t numbers(int rows) {
    return static_cast<std::size_t>(rows) * static_cast<std::size_t>(rows);
  }
  // Whether a system of so many rows, `others` of them not bilateral, has room.
  bool fits(int rows, int others) const {
    return rows <= static_cast<int>(scale_.size()) && numbers(rows) + numbers(others) <= room_.size();
  }
  // What solve() writes over, for others to use between its calls.
  std::span<double> room() { return room_; }

  // W: symmetric (m/N), positive diagonal, rows x rows in its top left corner; the system fits. delta_free (m) and
  // lambda (N) have one entry per law; lambda is the first guess; delta returns W lambda + delta_free. `budget`
  // bounds the steps of all kinds together; an answer converged if its residual is within the tolerance (N). Where one
  // of W or delta_free is not a number the forces are zero, without a step, and it has not converged.
  SolverResult solve(LawMethod method, Eigen::Ref<const MatrixX> W, std::span<const Law> laws,
                     std::span<const double> delta_free, StepBudget budget, double tolerance, std::span<double> lambda,
                     std::span<double> delta);

 private:
  // A violation: the larger of `force` (N) and `share` of force_scale().
  struct Target {
    double force = 0, share = 0;
    double at(std::span<const double> lambda) const { return std::max(force, share * force_scale(lambda)); }
  };

  // Makes the attempts, to `tolerance` (N), about the state, and again as long as that halves the residual, until it is
  // within the target. The state ends as the best answer seen, the one that it came with included.
  void solve_rounds(std::span<const Attempt> attempts, double tolerance, const Target& target, const LawSystem& full,
                    const LawState& state, StepBudget& budget, SolverResult& result);

  // Takes no force at all, where that violates the laws less.
  void prefer_open(const LawSystem& full, const LawState& state, SolverResult& result);

  std::vector<double> room_;  // of the reduced system's matrix, then of those of the attempts
  Attempts attempts_;
  ReducedLaws reduced_;
  std::vector<double> scale_;
  std::vector<double> trial_lambda_, trial_delta_;
};

}  // namespace acus
