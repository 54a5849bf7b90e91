// SPDX-License-Identifier: GPL-3.0-or-later
// Rotations of nodes, made smooth for the matrix R A0 Rᵀ of rungs `warped` and `refined`.
//
// That matrix is the one of the tissue at rest, with every node i turned by R_i. Where the R of an element's nodes differ,
// motions that leave its volume as it is change it in the eyes of R A0 Rᵀ, which resists them with the bulk modulus: an
// error of K |grad R| per length, without bound as nu nears 0.5. Where R lags behind an element's own rotation, the error
// is one of G |R - R_e|. So rotations are averaged over several elements: with trilinear weights w onto a grid over the
// tissue at rest, along axes that turn with its mesh, and back,
//
//   Q_g = sum over nodes i of w_ig v_i q_i,    q_i <- sum over g of w_ig Q_g,    both normalised,
//
// v_i the node's volume. A rotation of the whole stays as it is.
#pragma once

#include <array>
#include <vector>

#include "server/engine/math/types.h"
#include "server/engine/models/geometry/tetrahedral_mesh.h"

namespace acus {

// Of the grid, in mean sizes of an element (element_size()).
inline constexpr double kRotationGridSpacing = 4;

struct RotationGrid {
  struct Node {
    std::array<int, 8> points;      // of the grid cell around it
    std::array<double, 8> weights;  // w, sum to 1
    double volume = 0;              // m³, a quarter of the elements around it
  };
  std::vector<Node> nodes;
  int points = 0;
};

RotationGrid make_rotation_grid(const TetrahedralMesh& mesh);

// q: one unit quaternion per node (4 x nodes, w x y z), as likely q as -q; sums: memory (4 x grid points). Where rotations
// around a node cancel, its own stays.
void smooth_rotations(const RotationGrid& grid, Matrix4X& q, Matrix4X& sums);

// The same in parts: `sums` begin with zeros, nodes `first` to `last` - 1 add their rotations, and, once the sums are
// normalised, take theirs. `aligned`: all have one sign.
bool have_one_sign(const Matrix4X& q);
void add_to_grid(const RotationGrid& grid, const Matrix4X& q, bool aligned, int first, int last, Matrix4X& sums);
void normalize_grid(Matrix4X& sums);
void take_from_grid(const RotationGrid& grid, const Matrix4X& sums, bool aligned, int first, int last, Matrix4X& q);

}  // namespace acus
