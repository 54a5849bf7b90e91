// SPDX-License-Identifier: GPL-3.0-or-later
// Soft tissue: corotational linear tetrahedra (corotational_tetrahedron.h), with or without nodal pressures
// (nodal_pressure.h), lumped masses, Rayleigh damping per region, weight and pressures, fixed nodes. Unknowns are the
// free nodes' displacements, three per node, numbered 3 * free_index + axis.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "server/engine/math/types.h"
#include "server/engine/models/element/element_kernel.h"
#include "server/engine/models/element/material.h"
#include "server/engine/models/element/nodal_pressure.h"
#include "server/engine/models/element/tissue_element.h"
#include "server/engine/models/field/field_state.h"
#include "server/engine/models/geometry/tetrahedral_mesh.h"

namespace acus {

// Constant after load.
struct TissueModel {
  const TetrahedralMesh* mesh = nullptr;             // not owned; world placement
  std::vector<TetrahedronShape<double>> elements;    // per tetrahedron; lambda without what `pressure` has of it
  std::vector<ElementBatch> batches;
  NodalPressure pressure;
  std::vector<double> rayleigh_stiffness;            // beta per tetrahedron (s)
  std::vector<Octet> batch_damping;                  // the same per batch
  int branches = 0;                                  // of what tissue remembers, most of a region
  std::vector<Material> materials;                   // of tissue that remembers, per region,
  std::vector<int> material_of;                      // per tetrahedron
  VectorX mass;                                      // per node (kg)
  VectorX mass_damping;                              // per node: alpha m (kg/s)
  std::vector<int> free_index;                       // per node, -1 if fixed
  std::vector<int> free_nodes, fixed_nodes;
  Matrix3X applied;  // 3 x nodes (N, world), constant: weight, and what presses

  int nodes() const { return mesh->node_count(); }
  int unknowns() const { return 3 * static_cast<int>(free_nodes.size()); }
};

// `region_of` per tetrahedron indexes `materials`; `fixed` per node. The mesh must outlive the model.
TissueModel make_tissue_model(const TetrahedralMesh& mesh, std::span<const int> region_of,
                              std::span<const Material> materials, const std::vector<bool>& fixed,
                              const Vector3& gravity, TissueElement element = TissueElement::linear);

// out[node][axis]: the columns of x at the nodes of a tetrahedron.
inline void gather_nodes(const Matrix3X& x, const std::array<int, 4>& nodes, double (&out)[4][3]) {
  for (std::size_t k = 0; k < 4; ++k)
    for (int i = 0; i < 3; ++i) out[k][i] = x(i, nodes[k]);
}

// Rotation of every element as quaternions (w, x, y, z), in batches; the warm start of the next evaluation.
struct ElementRotations {
  std::vector<RotationBatch> batches;

  ElementRotations() = default;
  explicit ElementRotations(const TissueModel& model);  // none is turned

  void element(int tetrahedron, double (&q)[4]) const {
    const RotationBatch& b = batches[static_cast<std::size_t>(tetrahedron / kLanes)];
    for (int k = 0; k < 4; ++k) q[k] = b.q[k][tetrahedron % kLanes];
  }
};

// A tick's first step, as the next tick needs it to judge where it has ended (tissue_step.h).
struct TissueStep {
  double share = 0;    // of the step that was gone; 0: there is nothing to judge
  double descent = 0;  // d (J)
  double work = 0;     // of the elastic forces at the step's start over all of it (J)

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("share", self.share);
    visit("descent", self.descent);
    visit("work", self.work);
  }
};

inline Quaternion rotation_of(const Matrix4X& rotations, int node) {
  return {rotations(0, node), rotations(1, node), rotations(2, node), rotations(3, node)};
}

struct TissueState {
  Matrix3X x;                   // 3 x nodes (m), world
  Matrix3X v;                   // 3 x nodes (m/s)
  ElementRotations rotations;   // at the last evaluation
  TissueStep step;              // the last tick's
  int guarded = 0;              // linearisations to come in which steps are looked at
  // Of the last tick, for its balance of forces (N, world), which the next one completes.
  Vector3 support = Vector3::Zero();  // by the supports, but for the elastic part
  Vector3 inertia = Vector3::Zero();  // M a and mass-proportional drag of the free nodes
  bool moved = false;                 // there has been a tick
  std::optional<FieldState> field;    // of a tissue that has one
  std::optional<std::vector<StrainBatch>> crept;  // of a tissue that remembers: z at the tick before

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("x", self.x);
    visit("v", self.v);
    visit("rotations", self.rotations.batches);
    visit("step", self.step);
    visit("guarded", self.guarded);
    visit("support", self.support);
    visit("inertia", self.inertia);
    visit("moved", self.moved);
    visit("field", self.field);
    visit("crept", self.crept);
  }
};

// At rest, no element turned.
TissueState make_tissue_state(const TissueModel& model);

// Memory for one evaluation of the elements.
struct ElementScratch {
  Matrix4X x, forces;  // four numbers per node, the last unused
  VectorX patches;     // per patch, its change of volume (m³), then its pressure (Pa)

  explicit ElementScratch(const TissueModel& model);
};

// forces = dPsi/dx of the whole mesh (3 x nodes, N), overwritten, and the elements' rotations found from those of
// `start`, which may be the same; `memory`: what the elements remember, or null. Returns whether an element was flat or
// inside out.
bool elastic_forces(const TissueModel& model, const Matrix3X& x, const ElementRotations& start,
                    ElementRotations& rotations, ElementScratch& scratch, Matrix3X& forces,
                    const MemoryArrays* memory = nullptr);
// The same, for once.
bool elastic_forces(const TissueModel& model, const Matrix3X& x, ElementRotations& rotations, Matrix3X& forces);

// Of batches `first` to `last` - 1 alone, without nodal pressures: adds their forces at scratch.x to scratch.forces.
bool add_elastic_forces(const TissueModel& model, int first, int last, const ElementRotations& start,
                        ElementRotations& rotations, ElementScratch& scratch);

// forces = R beta K0 Rᵀ v of the whole mesh (3 x nodes, N), overwritten, with the elements' rotations as they are: what
// must be applied from outside to move the nodes at v (3 x nodes, m/s) against the damping of the stiffness.
void damping_forces(const TissueModel& model, const Matrix3X& v, const ElementRotations& rotations,
                    ElementScratch& scratch, Matrix3X& forces);

// Elastic energy (J).
double elastic_energy(const TissueModel& model, const Matrix3X& x, const ElementRotations& rotations);
double kinetic_energy(const TissueModel& model, const TissueState& state);
// Of the applied forces, zero where the nodes are in the origin; fixed nodes count, too.
double potential_energy(const TissueModel& model, const TissueState& state);

// Rotation of every node, the volume-weighted mean of its elements' (4 x nodes, w x y z).
void node_rotations(const TissueModel& model, const ElementRotations& rotations, Matrix4X& q);
// The same in parts: q begins with zeros, batches `first` to `last` - 1 add theirs, knowing whether all have one sign,
// and the sums are normalised.
bool have_one_sign(const TissueModel& model, const ElementRotations& rotations);
void add_node_rotations(const TissueModel& model, int first, int last, const ElementRotations& rotations, bool one_sign,
                        Matrix4X& q);
void normalize_rotations(Matrix4X& q);

}  // namespace acus
