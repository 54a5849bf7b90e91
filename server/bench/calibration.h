// SPDX-License-Identifier: GPL-3.0-or-later
// What the times of ticks are compared with: well-known work of the same size, done on the same core in the same run.
// Absolute times of a shared machine drift; ratios to these do not.
//
//   substitutions  CHOLMOD's own cholmod_solve2(CHOLMOD_A) with a supernodal factor of the tick's matrix
//                  A = M/h² + B/h + K of the tissue at rest: permutation, L x = b, Lᵀ x = b, permutation back. Double
//                  precision, one right-hand side, one thread, workspaces kept.
//   dense          Eigen's Cholesky factorisation of a symmetric matrix of 200 rows, in place.
#pragma once

#include <cholmod.h>

#include "server/math/sparse_cholesky.h"
#include "server/math/types.h"
#include "server/simulation/simulation.h"

namespace acus {

// A of the simulation's scene, lower triangle of the free unknowns; 0 x 0 without tissue.
SparseMatrix tick_matrix(const Simulation& simulation);

// How CHOLMOD numbers the unknowns.
enum class Ordering {
  standard,   // as cholmod_start() leaves it to choose
  least_fill  // the least entries of AMD, METIS and nested dissection
};

class CholmodSolve {
 public:
  // Factorises; throws std::runtime_error if that fails.
  CholmodSolve(const SparseMatrix& lower_triangle, Ordering ordering);
  ~CholmodSolve();
  CholmodSolve(const CholmodSolve&) = delete;
  CholmodSolve& operator=(const CholmodSolve&) = delete;

  // A x = b for a b of ones.
  void run();
  Eigen::Map<const VectorX> solution() const;

  std::size_t factor_entries() const { return factor_->xsize; }
  const char* ordering_name() const;

 private:
  cholmod_common common_{};
  cholmod_factor* factor_ = nullptr;
  cholmod_dense* right_side_ = nullptr;
  cholmod_dense* solution_ = nullptr;
  cholmod_dense* scratch_[2]{};
};

class DenseCholesky {
 public:
  static constexpr int kRows = 200;

  DenseCholesky();
  void run();

 private:
  MatrixX matrix_;
  MatrixX factor_;
};

}  // namespace acus
