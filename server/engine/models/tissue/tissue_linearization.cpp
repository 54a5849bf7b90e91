// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/models/tissue/tissue_linearization.h"

#include <cassert>
#include <optional>

#include "server/engine/models/field/field_tick.h"
#include "server/engine/models/tissue/tissue_step.h"

namespace acus {

namespace {

constexpr double kAheadShare = 1.0 / 6;  // of a tick's work, for columns that may be asked for soon

// Elastic forces at x_k; on the first call of a tick also what the last tick's step came to, and its supports carried,
// by the forces with which it ended, before tissue that remembers takes the strains there into memory.
void evaluate(const TissueSystem& system, const TissueState& state, TissueScratch& scratch) {
  if (system.matrix == TissueMatrix::constant) {
    system.stiffness->forces(scratch.x, scratch.velocity, scratch.elastic);
  } else {
    const bool first = scratch.iteration == 0;
    const ElementRotations& start = first ? state.rotations : scratch.element_rotations;
    std::optional<MemoryArrays> memory;
    if (system.memory) memory = system.memory->arrays(first ? *state.crept : scratch.crept);
    const bool inverted = elastic_forces(system.model, scratch.x, start, scratch.element_rotations, scratch.elements,
                                         scratch.elastic, memory ? &*memory : nullptr);
    scratch.inverted = scratch.inverted || inverted;
    if (scratch.iteration == 0 && state.step.share > 0) {
      scratch.step = state.v * (system.h / state.step.share);
      judge_step(system, state.step, scratch);
    } else if (scratch.iteration == 1) {
      judge_step(system, scratch.first, scratch);
    }
  }
  if (system.matrix == TissueMatrix::turned) {
    node_rotations(system.model, scratch.element_rotations, scratch.rotations);
    smooth_rotations(system.rotation_grid, scratch.rotations, scratch.rotation_sums);
  }
  if (scratch.iteration > 0) return;
  scratch.balance = {state.support, state.moved ? system.applied : Vector3(Vector3::Zero()), state.inertia};
  for (const int i : system.model.fixed_nodes) scratch.balance.support += scratch.elastic.col(i);
  if (system.memory)
    relax(system.model, *system.memory, scratch.x, scratch.element_rotations, *state.crept, scratch.crept,
          scratch.elements, scratch.elastic);
}

bool refactorize(const TissueSystem& system, TissueScratch& scratch) {
  const double h = system.h;
  // The Hessian at x_k; where it is indefinite, the turned rest stiffness, which never is.
  for (const Tangent tangent : {Tangent::exact, Tangent::turned}) {
    system.assembler.assemble(scratch.x, scratch.element_rotations, tangent, {1 / (h * h), 1 / h, 1, 0},
                              scratch.matrix);
    if (system.damped)
      Eigen::Map<VectorX>(scratch.matrix.valuePtr(), scratch.matrix.nonZeros()) +=
          Eigen::Map<const VectorX>(scratch.damping.valuePtr(), scratch.damping.nonZeros()) / h;
    if (scratch.own_factor->factorize(scratch.matrix)) {
      scratch.own_factor->keep(Precision::double_precision);
      return tangent == Tangent::exact;
    }
  }
  return false;
}

// -g at x_k into y, in the factor's frame and order.
void put_residual(const TissueSystem& system, const TissueState& state, TissueScratch& scratch) {
  const double h = system.h;
  for (int f = 0; f < static_cast<int>(system.position.size()); ++f) {
    const int i = system.model.free_nodes[f];
    Vector3 residual =
        system.model.applied.col(i) + system.model.mass[i] * (state.v.col(i) / h) - scratch.elastic.col(i);
    if (scratch.iteration > 0) {  // on the first, x_k = x_n
      const Vector3 velocity = (scratch.x.col(i) - state.x.col(i)) / h;
      residual -= (system.model.mass[i] / h + system.model.mass_damping[i]) * velocity + scratch.damping_force.col(i);
    }
    in_factor(system, scratch, f) = to_factor(system, scratch, i, residual);
  }
}

// The damping of the stiffness, beta R K0 Rᵀ (x_k - x_n)/h with R of the start of the tick.
void evaluate_damping(const TissueSystem& system, const TissueState& state, TissueScratch& scratch) {
  scratch.velocity = (scratch.x - state.x) / system.h;
  damping_forces(system.model, scratch.velocity, scratch.start_rotations, scratch.elements, scratch.damping_force);
}

// Of the factor, that a tick goes through, or what costs as much.
double entries_of_tick(const TissueSystem& system, const TissueScratch& scratch) {
  return system.field ? scratch.field->worker.task().cost() / system.field->window
                      : 2.0 * static_cast<double>(scratch.factor(system).factor_entries());
}

}  // namespace

void begin_tissue(const TissueSystem& system, const TissueState& state, TissueScratch& scratch) {
  assert(state.x.cols() == scratch.x.cols() && state.v.cols() == scratch.x.cols());
  scratch.x = state.x;
  scratch.iteration = 0;
  scratch.inverted = false;
  scratch.guarded = state.guarded;
  scratch.first = {};
  scratch.rows->corridor().begin_use(kAheadShare * entries_of_tick(system, scratch));
  if (system.field) begin_field(system, state, scratch);
}

bool linearize_tissue(const TissueSystem& system, const TissueState& state, TissueScratch& scratch) {
  if (system.empty()) return true;
  if (system.field) {
    move_field_freely(system, state, scratch);
    ++scratch.iteration;
    return true;
  }
  if (scratch.iteration == 1) scratch.start_rotations.batches = scratch.element_rotations.batches;
  evaluate(system, state, scratch);
  if (system.damped && scratch.iteration > 0) evaluate_damping(system, state, scratch);
  put_residual(system, state, scratch);
  bool exact = true;
  if (system.matrix == TissueMatrix::refactorized) {
    if (system.damped && scratch.iteration == 0)
      system.assembler.assemble(scratch.x, scratch.element_rotations, Tangent::turned, {.stiffness_damping = 1},
                                scratch.damping);
    exact = refactorize(system, scratch);
    scratch.rows->corridor().clear();
  }
  ++scratch.iteration;
  scratch.factor(system).forward(scratch.y, scratch.panel_rows);
  return exact;
}

}  // namespace acus
