// SPDX-License-Identifier: GPL-3.0-or-later
// Linear elasticity about the rest shape, f = K0 (x - X), as a product with the assembled stiffness of all nodes, fixed
// ones included: no element is visited. K0 is symmetric; blocks on and above the diagonal are kept.
#pragma once

#include <vector>

#include "server/engine/models/tissue/tissue.h"

namespace acus {

class RestStiffness {
 public:
  explicit RestStiffness(const TissueModel& model);

  // forces = K0 (x - X), 3 x nodes (N), overwritten: what must be applied from outside. `displacement` (3 x nodes) is
  // scratch.
  void forces(const Matrix3X& x, Matrix3X& displacement, Matrix3X& forces) const;

 private:
  struct Block {
    int column;
    double k[9];  // column-major (N/m)
  };

  const TetrahedralMesh& mesh_;
  std::vector<int> start_;  // per node, its first block; the end behind the last
  std::vector<Block> blocks_;
};

}  // namespace acus
