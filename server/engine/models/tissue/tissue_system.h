// SPDX-License-Identifier: GPL-3.0-or-later
// What a tick of the tissue needs and never changes: a factorised matrix and what goes with it.
//
// Matrix `constant` (rung linear): A0 = M/h² + B0/h + K0, factorised once, and K0 itself.
// Matrix `turned` (rungs warped, refined): the same A0, whose unknowns a tick turns by the nodes' rotations.
// Matrix `refactorized` (rung exact): its pattern alone; a tick factorises M/h² + B/h + K(x_k).
//
// The factor of a matrix that is factorised once is kept in as few bits as do (panel_values.h). Test displacements z,
// the three translations and one rough one, say how far rounding has moved it: A⁻¹ A z is compared with z.
//
// Half precision: of factors of kHalfPrecisionEntries, more than the caches near a core hold, if the test is off by at
// most kHalfPrecisionError. A tick then takes all but that share of a step, and the next one takes the rest, since the
// residual of a tick is always in double precision: neither rest shapes nor converged iterations depend on the rounding
// of the factor. Free motion, compliance and correction are of the one rounded matrix, so laws hold exactly.
//
// Single precision: unless the test is off by more than kSinglePrecisionError, as by a stiff inclusion that only soft
// tissue holds. Else double.
#pragma once

#include <optional>
#include <vector>

#include "server/engine/models/element/rotation_grid.h"
#include "server/engine/models/field/deferred_field.h"
#include "server/engine/models/tissue/rest_stiffness.h"
#include "server/engine/models/tissue/tissue.h"
#include "server/engine/models/tissue/tissue_assembler.h"
#include "server/engine/models/tissue/tissue_memory.h"

namespace acus {

enum class TissueMatrix { constant, turned, refactorized };

struct TissueSystem {
  static constexpr std::size_t kHalfPrecisionEntries = 2'000'000;
  static constexpr double kHalfPrecisionError = 0.15;    // -
  static constexpr double kSinglePrecisionError = 1e-4;  // -
  static constexpr double kLargeStep = 0.1;              // -, of the mean element size

  // Throws UnfitTissue if the factorisation fails. The model must outlive the system. One without free nodes is
  // no tissue: nothing is computed.
  //
  // `window` > 0: the tissue has a deferred field of so many ticks (deferred_field.h), which takes matrix `turned`,
  // linear elements, supports and damping of the stiffness. Its factor is that of c2 K, K being K0, or, of tissue that
  // begins in an `equilibrium`, the Hessian there, unless some motion has less than 0.3 of K0 left. Null: it begins at
  // rest in the mesh's shape. `threaded`: the work of windows has a thread of its own (field_worker.h). Tissue that
  // remembers (tissue_memory.h) takes matrix `turned` and no field.
  TissueSystem(const TissueModel& model, double h, TissueMatrix matrix, int window = 0, bool threaded = false,
               const TissueState* equilibrium = nullptr);
  TissueSystem(const TissueSystem&) = delete;
  TissueSystem& operator=(const TissueSystem&) = delete;

  bool empty() const { return model.free_nodes.empty(); }

  const TissueModel& model;
  double h;                                 // s
  TissueMatrix matrix;
  bool damped;                              // beta is not zero everywhere
  double largest_damping = 0;               // s, largest beta
  double large_step = 0;                    // m, of a node, to be looked at
  Vector3 applied = Vector3::Zero();        // to the free nodes, weight and pressures (N)
  std::optional<TissueMemory> memory;       // of tissue that remembers
  TissueAssembler assembler;
  SparseCholesky factor;                    // of the rest shape's matrix, or with a field of c2 K
  std::vector<int> position;                // per free node, of its first unknown in the factor
  std::optional<DeferredField> field;
  std::optional<RestStiffness> stiffness;   // constant
  RotationGrid rotation_grid;               // turned
  std::vector<int> beside_supports;         // free nodes that a matrix entry couples to a fixed one
  std::vector<Matrix3> damping_sums;        // for each of them, sum over free rows of beta K0
};

// Of matrix `turned`: rotation of every node, made smooth (4 x nodes, unit, w x y z), the frames of its unknowns.
Matrix4X node_frames(const TissueSystem& system, const ElementRotations& rotations);

// Energy of the rung's own elastic forces (J), with the elements' rotations found last.
double elastic_energy(const TissueSystem& system, const TissueState& state);

}  // namespace acus
