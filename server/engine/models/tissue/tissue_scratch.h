// SPDX-License-Identifier: GPL-3.0-or-later
// What a tick needs of the tissue besides its state: the iterate, the step from it, and the rows.
// tissue_linearization.h, tissue_row_forces.h and tissue_step.h work on it, in this order; from begin_tissue() to
// commit_tissue() it belongs to one tick. The corridor is a cache: no result depends on what it holds.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "server/engine/models/field/field_worker.h"
#include "server/engine/models/tissue/tissue_rows.h"
#include "server/engine/models/tissue/tissue_system.h"

namespace acus {

// Sums for the balance of forces (N, world). The elastic part of the supports' force is known only at the next
// linearisation, which evaluates the elements there: the balance is that of the tick before.
struct TissueBalance {
  Vector3 support = Vector3::Zero();  // by the fixed nodes' supports on the tissue
  Vector3 applied = Vector3::Zero();  // weight of the free nodes, and what presses on them
  Vector3 inertia = Vector3::Zero();  // M a and mass-proportional drag of the free nodes
};

// What a tick of a deferred field needs besides (field_tick.h). Lists per held node go with FieldState::held.
struct FieldScratch {
  FieldScratch(const TissueSystem& system, int room);

  FieldState now;                                       // the state, as this tick makes it
  bool crossed = false;                                 // a window has begun in this tick
  Matrix3X v;                                           // then, of the field
  // Memory: of the state's window, the next one, the one after, and two of states that somebody keeps.
  std::array<std::shared_ptr<FieldWindow>, 5> windows;
  FieldWorker worker;
  std::shared_ptr<const FieldWindow> foreign;           // the state's that is none of these: not to be freed in a tick
  std::vector<int> held_of;                             // per free node, -1: it is not held
  std::vector<int> slots;                               // per held node, in the corridor
  std::vector<int> held_in;                             // per slot, what is held there

  // Per held node, a cache of Yᵀ y and Yᵀ y_defect of a window (m).
  std::shared_ptr<const FieldWindow> read;
  std::vector<int> read_of;  // free nodes
  Matrix3X moved_by_p, moved_by_defect;

  // Per held node, in its rest frame.
  Matrix3X p_free;              // N, without the rows' forces
  Matrix3X free_motion;         // m
  Matrix3X moved, step, force;  // m of this tick so far; m; N by the rows
  VectorX products;             // G p_free, per slot
  VectorX d_free;               // modes: d without the rows' forces
  VectorX shift;                // what they move by besides G p_free
  VectorX modes, of_held;       // room
  FieldShares shares;           // FieldState's, at the end of the tick
};

struct TissueScratch {
  // `max_nodes`: the most nodes that rows of one tick touch.
  TissueScratch(const TissueSystem& system, int max_rows, int max_nodes);
  TissueScratch(const TissueScratch&) = delete;
  TissueScratch& operator=(const TissueScratch&) = delete;

  const SparseCholesky& factor(const TissueSystem& system) const { return own_factor ? *own_factor : system.factor; }
  bool finite() const;

  std::optional<SparseCholesky> own_factor;  // refactorized
  MatrixX panel_rows;                        // scratch of the factor
  std::optional<TissueRows> rows;            // made once there is a factor

  // The iterate.
  int iteration = 0;                   // of this tick, those done
  Matrix3X x;                          // x_k (m)
  Matrix3X elastic;                    // dPsi/dx at x_k
  ElementRotations element_rotations;  // there
  ElementRotations start_rotations;    // of the tick, from its second iteration on
  std::vector<StrainBatch> crept;      // of tissue that remembers: z at the start of the tick
  Matrix4X rotations;                  // turned: of the nodes, made smooth; a deferred field has those of its window
  Matrix4X rotation_sums;              // for smoothing
  VectorX y;                           // in the factor's order
  bool inverted = false;               // an element was, at any linearisation of the tick
  TissueBalance balance;

  // The step.
  Matrix3X step;                              // dx, zero for fixed nodes (m)
  double descent = 0;                         // d (J)
  double last_descent = 0;                    // of the iteration before in this tick, infinite in the first (J)
  TissueStep first;                           // what the state keeps of the tick's first step
  int guarded = 0;                            // linearisations in which steps are checked
  std::vector<Vector3> on_fixed;              // per row, the sum of its forces on fixed nodes, world
  Vector3 lambda_on_fixed = Vector3::Zero();  // N, of all rows

  // Room for computations.
  ElementScratch elements;
  Matrix3X trial_x, trial_forces;  // at the end of a share of the step
  ElementRotations trial_rotations;
  Matrix3X velocity;             // of the nodes in this tick; also a displacement, for constant
  Matrix3X damping_force;        // of the damping of the stiffness, from the tick's second iteration on
  SparseMatrix damping, matrix;  // refactorized: beta K of this tick, lower triangle; A
  std::optional<FieldScratch> field;
};

// ---- Between the world and the factor's frame (turned: the rest frame of each node) and order ----

inline Quaternion node_rotation(const TissueScratch& scratch, int node) {
  return rotation_of(scratch.field ? scratch.field->now.window->rotations : scratch.rotations, node);
}
inline Vector3 to_factor(const TissueSystem& system, const TissueScratch& scratch, int node, const Vector3& world) {
  return system.matrix == TissueMatrix::turned ? Vector3(node_rotation(scratch, node).conjugate() * world) : world;
}
// Of a free node, by its number among them.
inline auto in_factor(const TissueSystem& system, TissueScratch& scratch, int free) {
  return scratch.y.segment<3>(system.position[static_cast<std::size_t>(free)]);
}

}  // namespace acus
