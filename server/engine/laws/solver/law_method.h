// SPDX-License-Identifier: GPL-3.0-or-later
// How the laws are solved, and what came of it.
#pragma once

#include <limits>

#include "protocol/enums.h"

namespace acus {

// Both end at the same forces, within their tolerances.
using LawMethod = protocol::LawSolver;

// What solutions took, whichever attempt made them (attempts.h).
struct LawSteps {
  int rounds = 0;      // about an iterate of the full system, see reduced_laws.h
  int sweeps = 0;      // of all attempts
  int picks = 0;       // of pieces, see pivoting.h
  int iterations = 0;  // see interior_point.h
  double work = 0;     // of all steps, see StepBudget (multiplications)

  LawSteps& operator+=(const LawSteps& other) {
    rounds += other.rounds;
    sweeps += other.sweeps;
    picks += other.picks;
    iterations += other.iterations;
    work += other.work;
    return *this;
  }
};

// The steps that are left, sweeps, picks and interior-point iterations alike, and the work: multiplications, of those
// loops that grow fastest with the rows. Work is counted, not timed, so that the same tick ends with the same forces
// everywhere.
class StepBudget {
 public:
  StepBudget(int steps, double work = std::numeric_limits<double>::infinity()) : steps_(steps), work_(work) {}

  // Takes a step of so much work; false, and nothing is taken, if there is no step left or not enough work.
  bool take(double work) {
    spent_ = spent_ || steps_ <= 0 || taken_ + work > work_;
    if (spent_) return false;
    --steps_;
    taken_ += work;
    return true;
  }
  bool spent() const { return spent_ || steps_ <= 0; }
  double taken() const { return taken_; }

  // Of a Cholesky factorisation of so many rows, and of a matrix of so many rows times a vector.
  static double factorisation(double rows) { return rows * rows * rows / 6; }
  static double product(double rows) { return rows * rows; }

 private:
  int steps_;
  double work_;
  double taken_ = 0;  // of the work
  bool spent_ = false;
};

struct SolverResult {
  bool converged = false;                      // residual within the tolerance asked for
  LawMethod method = LawMethod::gauss_seidel;  // which one answered
  bool fell_back = false;                      // direct was asked for, and Gauss-Seidel has swept in its place
  bool capped = false;                         // out of steps before the method's own end
  LawSteps steps;
  int sweeps = 0;       // of Gauss-Seidel; not those with which the direct method starts
  double residual = 0;  // N, largest violation of a law at the end
};

}  // namespace acus
