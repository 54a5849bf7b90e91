// SPDX-License-Identifier: GPL-3.0-or-later
// Dense linear algebra that tests compare with. Compiled once: each file that names one of Eigen's decompositions
// itself takes seconds longer to compile. Units are the caller's. Shapes that do not fit fail an assertion.
#pragma once

#include "server/engine/math/types.h"

namespace acus::test {

// x (n x m) with a x = b, a n x n and regular, by LU with partial pivoting. Where a is singular, x has entries that are
// huge or not finite.
MatrixX solve_dense(const MatrixX& a, const MatrixX& b);

// Of a (n x n), as solve_dense() with the identity.
MatrixX inverse(const MatrixX& a);

// Of a (n x n, symmetric; the upper triangle is not read), n of them in ascending order.
VectorX eigenvalues(const MatrixX& a);

// Lower L (n x n) with a = L Lᵀ, a n x n, symmetric; fails the test case where a is not positive definite.
MatrixX cholesky_factor(const MatrixX& a);

// An orthogonal n x n matrix, Q of a = Q R.
MatrixX orthogonal_factor(const MatrixX& a);

// f = U S Vᵀ by singular values (s in descending order, not negative): the rotation U Vᵀ of a regular f with
// det f > 0, and s.
struct Polar {
  Matrix3 rotation;
  Vector3 stretches;
};
Polar polar_decomposition(const Matrix3& f);

}  // namespace acus::test
