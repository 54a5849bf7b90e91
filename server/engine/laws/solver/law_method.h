// SPDX-License-Identifier: GPL-3.0-or-later
// How the laws are solved, and what came of it.
#pragma once

#include "protocol/enums.h"

namespace acus {

// Both end at the same forces, within their tolerances.
using LawMethod = protocol::LawSolver;

// Factorisations of the direct method, of all rows but the bilateral ones at most.
struct DirectSteps {
  int picks = 0;       // of pieces, see pivoting.h
  int iterations = 0;  // see interior_point.h

  DirectSteps& operator+=(const DirectSteps& other) {
    picks += other.picks;
    iterations += other.iterations;
    return *this;
  }
};

// The steps that are left: sweeps, picks and interior-point iterations alike.
class StepBudget {
 public:
  explicit StepBudget(int steps) : left_(steps) {}

  // Takes one; false if none is left.
  bool take() {
    if (left_ <= 0) return false;
    --left_;
    return true;
  }
  bool spent() const { return left_ <= 0; }

 private:
  int left_;
};

struct SolverResult {
  bool converged = false;                      // residual within the tolerance asked for
  LawMethod method = LawMethod::gauss_seidel;  // which one answered
  bool fell_back = false;                      // direct was asked for, and Gauss-Seidel has swept in its place
  bool capped = false;                         // out of steps before the method's own end
  DirectSteps steps;
  int sweeps = 0;       // of Gauss-Seidel; not those with which the direct method starts
  double residual = 0;  // N, largest violation of a law at the end
};

}  // namespace acus
