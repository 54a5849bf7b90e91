// SPDX-License-Identifier: GPL-3.0-or-later
// What rows see of a needle: W_n = H A⁻¹ Hᵀ of generalised forces Hᵀ that each act on the two nodes of one beam, with A
// the needle's block-tridiagonal matrix. Of its inverse Z, only the blocks on and beside the diagonal are formed; above
// them the columns of rows further along follow from one another (math/factor/block_tridiagonal.h),
//
//   Z_ij = G_i Z_i+1,j  for j > i,   Z_ii = C_i⁻ᵀ C_i⁻¹ + G_i Z_i+1,i.
//
// So the sweep goes from the last beam with rows to the first and carries Z Hᵀ of all rows passed, at two nodes: a
// fixed number of operations per pair of rows, however long the needle is.
#pragma once

#include <span>
#include <vector>

#include "server/engine/math/factor/block_tridiagonal.h"
#include "server/engine/models/needle/beam_element.h"

namespace acus {

// A row's generalised force Hᵀ, (f1, m1, f2, m2) on the nodes of a beam.
struct BeamRow {
  int beam;
  Vector12 force;
};

class NeedleCompliance {
 public:
  // Of a needle whose node 0 is held: block i of A is node i + 1.
  NeedleCompliance(int beams, int max_rows);

  // Adds W_n (m/N) to the lower triangle of W; rows[r] is row places[r] there.
  void add_to(const BlockTridiagonal& A, std::span<const BeamRow> rows, std::span<const int> places,
              Eigen::Ref<MatrixX> W);

 private:
  // One entry per row passed, one column per unknown of two neighbouring nodes: (Z Hᵀ)ᵀ.
  using Panel = Eigen::Matrix<double, Eigen::Dynamic, 12>;

  void sort(std::span<const BeamRow> rows);
  void go_to_beam(const BlockTridiagonal& A, int beam);
  void pass_row(const BeamRow& row);
  void add_column(std::span<const int> places, Eigen::Ref<MatrixX> W);

  std::vector<int> order_;             // rows, from the last beam to the first
  std::vector<int> ends_;              // scratch of the sort
  std::vector<int> places_;            // in W, of rows passed
  Panel panel_;                        // at the near and the far node of the beam that the sweep is at
  Matrix6 z_near_, z_beside_, z_far_;  // Z_ii, Z_i,i+1, Z_i+1,i+1 of its nodes' blocks i, i + 1
  VectorX column_;                     // of W_n, rows passed
  int passed_ = 0;
};

}  // namespace acus
