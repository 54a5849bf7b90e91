// SPDX-License-Identifier: GPL-3.0-or-later
// Matrices of the tissue's free unknowns: sums over the elements, and over the patches of nodal pressures.
#pragma once

#include <array>
#include <vector>

#include "server/engine/math/factor/sparse_cholesky.h"
#include "server/engine/models/tissue/tissue.h"

namespace acus {

// Which element stiffness a matrix is made of.
enum class Tangent { rest, turned, exact };  // K0, R K0 Rᵀ, Hessian

// A sum over the elements and patches, restricted to the free unknowns, lower triangle:
//   mass M + mass_damping alpha M + stiffness K + stiffness_damping beta K
struct MatrixFactors {
  double mass = 0;
  double mass_damping = 0;
  double stiffness = 0;
  double stiffness_damping = 0;
};

// Of a tick's matrix M/h² + B/h + K.
constexpr MatrixFactors tick_factors(double h) {
  return {.mass = 1 / (h * h), .mass_damping = 1 / h, .stiffness = 1, .stiffness_damping = 1 / h};
}

// Such matrices, all of one pattern, found once.
class TissueAssembler {
 public:
  // `stiffening`: per tetrahedron, what its stiffness is multiplied by (tissue_memory.h); empty: 1.
  explicit TissueAssembler(const TissueModel& model, std::vector<double> stiffening = {});

  // Overwrites `matrix`, which must be empty or come from this assembler. With `frames` R (4 x nodes, unit, w x y z)
  // the unknowns of a node are along its own axes, dx = R dq, and K becomes Rᵀ K R; not of tissue with nodal pressures.
  void assemble(const Matrix3X& x, const ElementRotations& rotations, Tangent tangent, const MatrixFactors& factors,
                SparseMatrix& matrix, const Matrix4X* frames = nullptr) const;

 private:
  void add_patches(const PatchGradients& gradients, const MatrixFactors& factors, SparseMatrix& matrix) const;

  const TissueModel& model_;
  std::vector<double> stiffening_;              // of tissue that remembers
  SparseMatrix pattern_;                        // lower triangle, zeros
  std::vector<std::array<int, 78>> positions_;  // per element: where the lower triangle of its 12 x 12 goes, -1: nowhere
  std::vector<int> diagonal_;                   // per unknown
};

}  // namespace acus
