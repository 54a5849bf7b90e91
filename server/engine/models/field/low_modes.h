// SPDX-License-Identifier: GPL-3.0-or-later
// The slow motions of a tissue on its supports: Ritz vectors of K⁻¹ M, omega² the lowest of K phi = omega² M phi, from a
// block Krylov space that begins with the affine motions.
#pragma once

#include "server/engine/math/factor/sparse_cholesky.h"
#include "server/engine/math/types.h"

namespace acus {

// Unknowns in the factor's order x modes; what a node has of all modes lies together.
using ModeShapes = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

struct LowModes {
  VectorX omega2;    // rad²/s², rising
  ModeShapes shapes;  // Phi, Phiᵀ M Phi = 1 (kg^-0.5)

  Eigen::Index count() const { return omega2.size(); }
};

// `factor` is that of scale times K. `mass` per unknown (kg) in its order, `places` of the nodes (3 x nodes, m), one for each
// three unknowns. There are fewer modes than `most` where there are few unknowns.
LowModes find_low_modes(const SparseCholesky& factor, double scale, const VectorX& mass, const Matrix3X& places, int most);

}  // namespace acus
