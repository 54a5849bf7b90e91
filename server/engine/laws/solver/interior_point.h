// SPDX-License-Identifier: GPL-3.0-or-later
// A primal-dual interior-point method for the laws of one row without bilateral ones: for rows so nearly dependent that
// pivoting loses its way among their pieces. With w_l, w_u >= 0, all these laws are
//
//   lambda = lambda_c - c delta,   l <= lambda_c <= u,   delta = w_l - w_u,
//   w_l (lambda_c - l) = 0,        w_u (u - lambda_c) = 0
//
// (unilateral l = 0, u = f, c = 0; friction u = -l = T), the optimality conditions of a convex quadratic program. Both
// products are kept at a common mu that goes to zero, by Newton's method: eliminated per row, with
// D = w_l/(lambda_c - l) + w_u/(u - lambda_c), each iteration is one Cholesky factorisation of W + D/(1 + c D), used
// twice, by Mehrotra's predictor and corrector ["On the implementation of a primal-dual interior point method", 1992].
// The number of iterations hardly grows with the condition of W or the number of rows: 7 to 25 have been seen. Path
// following of this kind takes O(n log 1/eps) in the worst case [Wright, "Primal-dual interior-point methods", 1997];
// kMaxIterations bounds it. It ends where no law is violated by more than kIterationsEnd of the largest force.
//
// Rows of contacts with friction and of cones keep their forces.
#pragma once

#include <vector>

#include "server/engine/laws/solver/law_method.h"
#include "server/engine/laws/solver/law_system.h"

namespace acus {

class InteriorPoint {
 public:
  static constexpr int kMaxIterations = 40;
  static constexpr double kIterationsEnd = 1e-12;  // violation, as share of the largest force, see force_scale()
  static constexpr double kToBoundary = 0.995;     // share of the way to the nearest bound that a step may go
  static constexpr double kRegularization = 1e-12;

  // `room`: as for Pivoting.
  InteriorPoint(int capacity, const std::span<double>& room);

  // Leaves forces within all bounds, and their displacements. Returns the number of iterations, each of which it takes
  // from `budget`.
  int solve(const LawSystem& system, const LawState& state, StepBudget& budget);

 private:
  // One side of a row's range: slack >= 0 to its bound and pressure >= 0 on it, both in N (the pressure as w/W_ii), how
  // a full step changes them, and what their product is to be after it (N²).
  struct Side {
    bool bounded = false;
    double slack = 1, pressure = 0;
    double slack_step = 0, pressure_step = 0;
    double target = 0;

    double stiffness() const { return bounded ? pressure / slack : 0; }
    double push() const { return bounded ? target / slack : 0; }
    void set_step(double change);
  };
  // Displacements in units of W_ii x 1 N: all numbers are forces.
  struct Range {
    double force = 0;      // lambda_c
    double viscosity = 0;  // c W_ii (-)
    bool pinned = false;   // l = u = 0: sliding with viscosity alone
    Side lower, upper;

    double stiffness() const;  // D/(1 + c D) (-)
    double pull() const;       // what delta would be at lambda = 0
    void set_step(double lambda);
  };

  void begin(const LawSystem& system, const LawState& state);
  void begin_range(const LawSystem& system, int row, const LawState& state);
  Eigen::Map<MatrixX> matrix() {  // m/N
    const auto n = static_cast<Eigen::Index>(rows_.size());
    return {room_.data(), n, n};
  }
  bool factorize(const LawSystem& system);
  void find_step(const LawSystem& system);
  double longest_step() const;
  double mean_product(double step) const;
  void set_targets(double mu, bool corrector);
  void advance(const LawSystem& system, double step, const LawState& state);

  std::vector<int> rows_;
  std::vector<Range> ranges_;      // of rows_
  const std::span<double>& room_;  // of matrix()
  VectorX free_;                   // m, displacements at zero force of rows_
  VectorX lambda_;                 // N, of rows_ after a full step
};

}  // namespace acus
