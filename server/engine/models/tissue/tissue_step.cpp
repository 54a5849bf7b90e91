// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/models/tissue/tissue_step.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <optional>

#include "server/engine/math/step_share.h"
#include "server/engine/models/field/field_tick.h"

namespace acus {

namespace {

// In large steps: of a smaller one rounding would decide.
constexpr double kLeastJudged = 1e-9;

// Of the merit at the end of a share of a step (J): `resistance` is dxᵀ (M/h² + B/h) dx.
double merit_slope(double share, double descent, double resistance, const Matrix3X& step, const Matrix3X& start_forces,
                   const Matrix3X& end_forces) {
  return -descent + share * resistance + (end_forces - start_forces).cwiseProduct(step).sum();
}

// Of K0 in the matrix.
double least_stiffening(const TissueSystem& system) { return system.memory ? system.memory->least_stiffening : 1; }

// dxᵀ (M/h² + B/h) dx of a step (J), the elements turned as given; `first`: of a tick's first step.
double resistance(const TissueSystem& system, const Matrix3X& step, double descent, const ElementRotations& rotations,
                  bool first, TissueScratch& scratch) {
  const double h = system.h;
  double inertia = 0;
  for (const int i : system.model.free_nodes)
    inertia += (system.model.mass[i] / h + system.model.mass_damping[i]) / h * step.col(i).squaredNorm();
  if (!system.damped) return inertia;
  if (system.matrix == TissueMatrix::turned && first)
    return descent - (descent - inertia) / (1 + system.largest_damping / (h * least_stiffening(system)));
  damping_forces(system.model, step, rotations, scratch.elements, scratch.damping_force);
  return inertia + scratch.damping_force.cwiseProduct(step).sum() / h;
}

}  // namespace

void judge_step(const TissueSystem& system, const TissueStep& first, TissueScratch& scratch) {
  const double rise = scratch.elastic.cwiseProduct(scratch.step).sum() - first.work;
  if (rise <= first.descent) return;
  const double end =
      -first.descent +
      first.share * resistance(system, scratch.step, first.descent, scratch.element_rotations, true, scratch) + rise;
  if (!(end <= first.descent)) scratch.guarded = kGuardedTicks;
}

void solve_tissue(const TissueSystem& system, std::span<const double> lambda, TissueScratch& scratch) {
  scratch.lambda_on_fixed.setZero();
  if (system.empty()) return;
  for (int r = 0; r < scratch.rows->count(); ++r) scratch.lambda_on_fixed += lambda[r] * scratch.on_fixed[r];
  if (system.field) return solve_field(system, lambda, scratch);
  scratch.rows->add_forces(lambda, scratch.y);
  scratch.last_descent = scratch.iteration > 1 ? scratch.descent : std::numeric_limits<double>::infinity();
  scratch.descent = scratch.y.squaredNorm();
  scratch.factor(system).backward(scratch.y, scratch.panel_rows);
  for (int f = 0; f < static_cast<int>(system.position.size()); ++f) {
    const int i = system.model.free_nodes[f];
    scratch.step.col(i) = system.matrix == TissueMatrix::turned
                              ? Vector3(node_rotation(scratch, i) * in_factor(system, scratch, f))
                              : Vector3(in_factor(system, scratch, f));
  }
}

double trusted_tissue_share(const TissueSystem& system, TissueScratch& scratch) {
  if (system.empty() || system.matrix == TissueMatrix::constant || system.field) return 1;
  const double largest = scratch.step.cwiseAbs().maxCoeff();
  const bool far = !(largest <= system.large_step), longer = !(scratch.descent <= scratch.last_descent);
  const bool looked_at = scratch.guarded > 0 || far || longer;
  if (!looked_at || largest <= kLeastJudged * system.large_step) return 1;
  const bool first = scratch.iteration == 1;
  const double resisting = resistance(system, scratch.step, scratch.descent,
                                      first ? scratch.element_rotations : scratch.start_rotations, first, scratch);
  if (scratch.guarded > 0) --scratch.guarded;
  std::optional<MemoryArrays> memory;
  if (system.memory) memory = system.memory->arrays(scratch.crept);
  double share = 1;
  for (int i = 0; i < kMaxTissueTrials; ++i) {
    scratch.trial_x = scratch.x + share * scratch.step;
    elastic_forces(system.model, scratch.trial_x, i == 0 ? scratch.element_rotations : scratch.trial_rotations,
                   scratch.trial_rotations, scratch.elements, scratch.trial_forces, memory ? &*memory : nullptr);
    const double end =
        merit_slope(share, scratch.descent, resisting, scratch.step, scratch.elastic, scratch.trial_forces);
    if (end <= scratch.descent) break;
    share = cut_share(share, scratch.descent, end);
  }
  if (share < 1) scratch.guarded = kGuardedTicks;
  return share;
}

double move_tissue(const TissueSystem& system, double share, TissueScratch& scratch) {
  assert(share > 0 && share <= 1);
  if (system.empty()) return 0;
  if (system.field) return move_field(system, share, scratch);
  scratch.first = {};
  if (scratch.iteration == 1 && system.matrix != TissueMatrix::constant)
    scratch.first = {share, scratch.descent, scratch.elastic.cwiseProduct(scratch.step).sum()};
  scratch.x += share * scratch.step;
  return share * scratch.step.cwiseAbs().maxCoeff();
}

void commit_tissue(const TissueSystem& system, TissueScratch& scratch, TissueState& state) {
  if (system.field) return commit_field(system, scratch, state);
  state.guarded = scratch.guarded;
  state.step = scratch.first;
  state.inertia.setZero();
  state.moved = true;
  for (const int i : system.model.free_nodes) {
    const Vector3 velocity = (scratch.x.col(i) - state.x.col(i)) / system.h;
    state.inertia +=
        system.model.mass[i] * (velocity - state.v.col(i)) / system.h + system.model.mass_damping[i] * velocity;
    scratch.velocity.col(i) = velocity;
    state.v.col(i) = velocity;
    state.x.col(i) = scratch.x.col(i);
  }
  for (const int i : system.model.fixed_nodes) scratch.velocity.col(i).setZero();
  state.support = -scratch.lambda_on_fixed;
  if (system.damped) {
    if (scratch.iteration > 1 || system.matrix == TissueMatrix::refactorized) {
      damping_forces(system.model, scratch.velocity,
                     scratch.iteration > 1 ? scratch.start_rotations : scratch.element_rotations, scratch.elements,
                     scratch.damping_force);
      for (const int i : system.model.fixed_nodes) state.support += scratch.damping_force.col(i);
    } else {
      for (std::size_t k = 0; k < system.beside_supports.size(); ++k)
        state.support -= system.damping_sums[k] * scratch.velocity.col(system.beside_supports[k]);
    }
  }
  std::swap(state.rotations.batches, scratch.element_rotations.batches);
  if (system.memory) std::swap(*state.crept, scratch.crept);
}

}  // namespace acus
