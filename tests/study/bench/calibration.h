// SPDX-License-Identifier: GPL-3.0-or-later
// What the times of ticks are compared with: well-known work of the same size, done on the same core in the same run.
// Absolute times of a shared machine drift; ratios to these do not.
//
//   substitutions  CHOLMOD's own cholmod_solve2(CHOLMOD_A) with a supernodal factor of the tick's matrix
//                  A = M/h² + B/h + K of the tissue at rest: permutation, L x = b, Lᵀ x = b, permutation back. Double
//                  precision, one right-hand side, one thread, workspaces kept. Once with the order of elimination that
//                  the simulation itself uses, once with CHOLMOD's own choice.
//   two reads      as many bytes as the simulation's factor has, read twice and added up: the bound of a tick that
//                  reads the factor twice.
//   dense          Eigen's Cholesky factorisation of a symmetric matrix of 200 rows, in place.
#pragma once

#include <cholmod.h>

#include <vector>

#include "server/engine/math/factor/sparse_cholesky.h"
#include "server/engine/math/types.h"
#include "server/engine/tick/simulation.h"

namespace acus {

// A of the simulation's scene, lower triangle of the free unknowns; 0 x 0 without tissue.
SparseMatrix tick_matrix(const Simulation& simulation);

// In which order to eliminate the unknowns of that matrix, as the simulation does: the unknown eliminated k-th.
std::vector<int> simulation_order(const SparseMatrix& lower_triangle);

class CholmodSolve {
 public:
  // Factorises in a given order, or, if it is empty, in the one that CHOLMOD chooses by itself. Throws
  // std::runtime_error if that fails.
  explicit CholmodSolve(const SparseMatrix& lower_triangle, std::vector<int> order = {});
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

class TwoReads {
 public:
  explicit TwoReads(std::size_t bytes) : numbers_(VectorX::Ones(static_cast<Eigen::Index>(bytes / sizeof(double)))) {}
  void run();

  double bytes() const { return sizeof(double) * static_cast<double>(numbers_.size()); }  // of one read

 private:
  VectorX numbers_;
  volatile double sum_ = 0;  // somebody wants it
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
