// SPDX-License-Identifier: GPL-3.0-or-later
// Soft tissue: corotational linear tetrahedra (corotational_tetrahedron.h), lumped masses, Rayleigh damping per region,
// gravity, fixed nodes. Unknowns are the free nodes' displacements, three per node, numbered 3 * free_index + axis.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "server/math/sparse_cholesky.h"
#include "server/math/types.h"
#include "server/models/corotational_tetrahedron.h"
#include "server/models/material.h"
#include "server/models/tetrahedral_mesh.h"

namespace acus {

using Matrix4X = Eigen::Matrix4Xd;

// kLanes elements side by side; unfilled lanes repeat the last element with zero volume.
struct ElementBatch {
  TetrahedronShape<Lanes> shape;
  int nodes[4][kLanes];
};

// Constant after load.
struct TissueModel {
  const TetrahedralMesh* mesh = nullptr;             // not owned; world placement
  std::vector<TetrahedronShape<double>> elements;    // per tetrahedron
  std::vector<ElementBatch> batches;
  std::vector<double> rayleigh_stiffness;            // beta per tetrahedron (s)
  std::vector<Lanes> batch_damping;                  // the same per batch
  VectorX mass;                                      // per node (kg)
  VectorX mass_damping;                              // per node: alpha m (kg/s)
  std::vector<int> free_index;                       // per node, -1 if fixed
  std::vector<int> free_nodes, fixed_nodes;
  Vector3 gravity = Vector3::Zero();                 // m/s²

  int nodes() const { return mesh->node_count(); }
  int unknowns() const { return 3 * static_cast<int>(free_nodes.size()); }
};

// `region_of` per tetrahedron indexes `materials`; `fixed` per node. The mesh must outlive the model.
TissueModel make_tissue_model(const TetrahedralMesh& mesh, std::span<const int> region_of,
                              std::span<const Material> materials, const std::vector<bool>& fixed,
                              const Vector3& gravity);

struct TissueState {
  Matrix3X x;  // 3 x nodes (m), world
  Matrix3X v;  // 3 x nodes (m/s)
};

TissueState make_tissue_state(const TissueModel& model);

// Rotation of every element as quaternions (w, x, y, z), in batches; the warm start of the next evaluation.
struct ElementRotations {
  struct Batch {
    Lanes q[4];
  };
  std::vector<Batch> batches;
  Matrix4X x, forces;  // scratch of elastic_forces(): four numbers per node, the last unused

  void reset(const TissueModel& model);
  void element(int tetrahedron, double (&q)[4]) const {
    const Batch& b = batches[static_cast<std::size_t>(tetrahedron / kLanes)];
    for (int k = 0; k < 4; ++k) q[k] = b.q[k][tetrahedron % kLanes];
  }
};

// forces = dPsi/dx of the whole mesh (3 x nodes, N), overwritten; rotations updated.
void elastic_forces(const TissueModel& model, const Matrix3X& x, ElementRotations& rotations, Matrix3X& forces);

// forces = R beta K0 Rᵀ v of the whole mesh (3 x nodes, N), overwritten, with the elements' rotations as they are: what
// must be applied from outside to move the nodes at v (3 x nodes, m/s) against the damping of the stiffness.
void damping_forces(const TissueModel& model, const Matrix3X& v, ElementRotations& rotations, Matrix3X& forces);

// Elastic energy (J).
double elastic_energy(const TissueModel& model, const Matrix3X& x, const ElementRotations& rotations);
double kinetic_energy(const TissueModel& model, const TissueState& state);
// Of gravity, zero where the nodes are in the origin; fixed nodes count, too.
double potential_energy(const TissueModel& model, const TissueState& state);

// Rotation of every node, the volume-weighted mean of its elements' (4 x nodes, w x y z).
void node_rotations(const TissueModel& model, const ElementRotations& rotations, Matrix4X& q);

// Which element stiffness a matrix is made of.
enum class Tangent { rest, turned, exact };  // K0, R K0 Rᵀ, Hessian

// A sum over the elements, restricted to the free unknowns, lower triangle:
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
  explicit TissueAssembler(const TissueModel& model);

  // Overwrites `matrix`, which must be empty or come from this assembler.
  void assemble(const Matrix3X& x, const ElementRotations& rotations, Tangent tangent, const MatrixFactors& factors,
                SparseMatrix& matrix) const;

 private:
  const TissueModel& model_;
  SparseMatrix pattern_;                        // lower triangle, zeros
  std::vector<std::array<int, 78>> positions_;  // per element: where the lower triangle of its 12 x 12 goes, -1: nowhere
  std::vector<int> diagonal_;                   // per unknown
};

}  // namespace acus
