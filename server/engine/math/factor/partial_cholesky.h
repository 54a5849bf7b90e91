// SPDX-License-Identifier: GPL-3.0-or-later
// Eliminates the first `count` unknowns of a dense symmetric matrix in place, lower triangle only:
//
//   | A11 A21ᵀ |      | L11    |      A11 = L11 L11ᵀ,  L21 = A21 L11⁻ᵀ,  S = A22 - L21 L21ᵀ
//   | A21 A22  |  ->  | L21  S |
//
// A11 must be positive definite; S, the Schur complement, is what the other unknowns are left with. The strict upper
// triangle is neither read nor written. Right-looking, in panels of fixed width [Golub, Van Loan, "Matrix
// Computations", 4.2.9]; products in tiles, so that Eigen finds room for its buffers on the stack. Nothing allocates.
#pragma once

#include <span>

#include "server/engine/math/types.h"

namespace acus {

// False, with A of no further use, if a pivot is not positive.
bool partial_cholesky(Eigen::Ref<MatrixX> A, Eigen::Index count);

// x <- (L Lᵀ)⁻¹ x, with the lower triangle of a matrix all of whose unknowns were eliminated.
void cholesky_solve(const Eigen::Ref<const MatrixX>& L, Eigen::Ref<VectorX> x);

// Makes a matrix symmetric: its strict upper triangle becomes the lower one's transpose.
void mirror_lower(Eigen::Ref<MatrixX> A);

// The lower triangle of some rows of a symmetric W, in the order given: out_ij = W_rows[i],rows[j] for i >= j.
void gather_lower(const Eigen::Ref<const MatrixX>& W, std::span<const int> rows, Eigen::Ref<MatrixX> out);

}  // namespace acus
