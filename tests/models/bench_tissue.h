// SPDX-License-Identifier: GPL-3.0-or-later
// Blocks of one material for the tests of the tissue.
#pragma once

#include <functional>
#include <vector>

#include "server/engine/models/tissue/tissue_assembler.h"
#include "tests/models/motions.h"

namespace acus {

// The mesh must outlive the model.
inline TissueModel bench_tissue(const TetrahedralMesh& mesh, const Material& material,
                                const std::function<bool(const Vector3&)>& is_fixed = nullptr,
                                const Vector3& gravity = Vector3::Zero(),
                                TissueElement element = TissueElement::linear) {
  const std::vector<int> region(mesh.tetrahedra.size(), 0);
  std::vector<bool> fixed(static_cast<std::size_t>(mesh.node_count()), false);
  if (is_fixed)
    for (int i = 0; i < mesh.node_count(); ++i) fixed[static_cast<std::size_t>(i)] = is_fixed(mesh.nodes.col(i));
  return make_tissue_model(mesh, region, {&material, 1}, fixed, gravity, element);
}

// A tissue's motion with a system of its own.
struct BenchSystem {
  TissueSystem system;
};
class BenchMotion : private BenchSystem, public TissueMotion {
 public:
  BenchMotion(const TissueModel& model, double h, TissueMatrix matrix, int max_rows, int max_nodes)
      : BenchSystem{{model, h, matrix}}, TissueMotion(system, max_rows, max_nodes) {}
};

inline Material undamped_material() {
  Material material;
  material.young_modulus = 10e3;
  material.poisson_ratio = 0.4;
  material.rayleigh_mass = 0;
  material.rayleigh_stiffness = 0;
  return material;
}

// The element rotations of the configuration x, with its forces.
inline ElementRotations rotations_at(const TissueModel& model, const Matrix3X& x, Matrix3X& forces) {
  ElementRotations rotations(model);
  forces.resize(3, model.nodes());
  elastic_forces(model, x, rotations, forces);
  return rotations;
}

inline MatrixX dense_matrix(const TissueModel& model, const Matrix3X& x, Tangent tangent,
                            const MatrixFactors& factors) {
  Matrix3X forces;
  const ElementRotations rotations = rotations_at(model, x, forces);
  SparseMatrix lower;
  TissueAssembler(model).assemble(x, rotations, tangent, factors, lower);
  return MatrixX(MatrixX(lower).selfadjointView<Eigen::Lower>());
}

}  // namespace acus
