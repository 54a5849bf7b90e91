// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/models/needle/needle_step.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "server/engine/math/rotation.h"
#include "server/engine/math/step_share.h"
#include "server/engine/models/needle/needle_base.h"
#include "server/engine/models/needle/needle_terms.h"
#include "server/engine/models/needle/rigid_needle.h"

namespace acus {

namespace {

constexpr double kLargeTurn = 0.05;  // rad, of a node in a step
constexpr int kMaxTrials = 8;        // of shares, in one step

// Hᵀ lambda on the free nodes into scratch.applied; the part on node 0, of a rigid needle all of it, is returned.
Vector6 add_row_forces(const NeedleModel& model, std::span<const double> lambda, NeedleScratch& scratch) {
  scratch.applied.setZero();
  Vector6 on_base = Vector6::Zero();
  for (std::size_t r = 0; r < scratch.rows.size(); ++r) {
    const int beam = scratch.rows[r].beam;
    const Vector6 near = lambda[r] * scratch.rows[r].force.head<6>(), far = lambda[r] * scratch.rows[r].force.tail<6>();
    if (model.rigid) {
      on_base += about_base(scratch, beam, near) + about_base(scratch, beam + 1, far);
      continue;
    }
    scratch.applied.segment<6>(6 * beam) += far;
    if (beam > 0)
      scratch.applied.segment<6>(6 * (beam - 1)) += near;
    else
      on_base += near;
  }
  return on_base;
}

void step_node(const NeedleScratch& scratch, int i, const Vector6& step, NeedleConfiguration& to) {
  to.shape.x.col(i) = scratch.iterate.shape.x.col(i) + step.head<3>();
  to.q[i] = (rotation_exp(step.tail<3>()) * scratch.iterate.q[i]).normalized();
  to.shape.frames[i] = to.q[i].toRotationMatrix();
}

// From q_k by a share of the step; `to` may be q_k itself.
void go(const NeedleModel& model, const NeedleScratch& scratch, double share, NeedleConfiguration& to) {
  if (model.rigid) return turn_about_base(model, scratch, share, to);
  to.shape.x.col(0) = scratch.iterate.shape.x.col(0);
  to.q[0] = scratch.iterate.q[0];
  to.shape.frames[0] = scratch.iterate.shape.frames[0];
  if (scratch.held) step_node(scratch, 0, share * scratch.base_step, to);
  for (int i = 1; i < model.nodes(); ++i) {
    step_node(scratch, i, share * scratch.dq.segment<6>(6 * (i - 1)), to);
  }
}

Vector6 velocity(const NeedleScratch& scratch, const NeedleState& state, int i) {
  Vector6 v;
  v << (scratch.iterate.shape.x.col(i) - state.x.col(i)) / scratch.h,
      rotation_log(scratch.iterate.q[i] * state.q[i].conjugate()) / scratch.h;
  return v;
}

}  // namespace

void solve_needle(const NeedleModel& model, std::span<const double> lambda, NeedleScratch& scratch) {
  scratch.on_base = add_row_forces(model, lambda, scratch);
  scratch.reaction = scratch.g.col(0) - scratch.on_base;
  if (!model.rigid) {
    scratch.dq = scratch.applied;
    scratch.matrix.forward(scratch.dq);
    scratch.matrix.backward(scratch.dq);
  }
  if (scratch.held) {
    Vector6 on_base = scratch.on_base;
    if (!model.rigid) on_base -= scratch.base_coupling * scratch.dq.head<6>();
    const Vector6 pushed = scratch.base_factor.solve(on_base);
    scratch.base_step = scratch.base_free + pushed;
    scratch.dq.noalias() += scratch.follow * pushed;
  }
  scratch.dq += scratch.dq_free;
}

bool turns_far(const NeedleScratch& scratch) {
  if (!(scratch.base_step.tail<3>().squaredNorm() <= kLargeTurn * kLargeTurn)) return true;
  for (int i = 0; i < scratch.dq.size(); i += 6)
    if (!(scratch.dq.segment<3>(i + 3).squaredNorm() <= kLargeTurn * kLargeTurn)) return true;
  return false;
}

double trusted_needle_share(const NeedleModel& model, const NeedleState& state, NeedleScratch& scratch) {
  if (model.rigid || !turns_far(scratch)) return 1;
  const auto slope = [&](const Matrix6X& g, const NeedleConfiguration& at) {
    const double of_free = g.rightCols(model.beams).reshaped().dot(scratch.dq) - scratch.applied.dot(scratch.dq);
    return scratch.held
               ? of_free + (g.col(0) - scratch.held->wrench(at.base()) - scratch.on_base).dot(scratch.base_step)
               : of_free;
  };
  const double descent = -slope(scratch.g, scratch.iterate);
  double share = 1;
  for (int i = 0; i < kMaxTrials; ++i) {
    go(model, scratch, share, scratch.trial);
    put_residual(model, scratch, state, scratch.trial, scratch.trial_g);
    const double end = slope(scratch.trial_g, scratch.trial);
    if (end <= descent) break;
    share = cut_share(share, descent, end);
  }
  return share;
}

double move_needle(const NeedleModel& model, double share, NeedleScratch& scratch) {
  assert(share > 0 && share <= 1);
  if (model.rigid && !scratch.held) return 0;
  scratch.reaction = scratch.g.col(0) - scratch.on_base;
  if (!model.rigid)
    scratch.reaction = scratch.g.col(0) + share * (scratch.base_coupling * scratch.dq.head<6>()) - scratch.on_base;
  if (scratch.held) scratch.reaction += share * (node_tangent(model, scratch) * scratch.base_step);
  go(model, scratch, share, scratch.iterate);
  scratch.is_carried = false;
  double largest = (share * scratch.base_step.head<3>()).cwiseAbs().maxCoeff();
  if (model.rigid) largest = std::max(largest, (share * step_of_tip(scratch)).cwiseAbs().maxCoeff());
  for (Eigen::Index i = 0; i < scratch.dq.size(); i += 6)
    largest = std::max(largest, (share * scratch.dq.segment<3>(i)).cwiseAbs().maxCoeff());
  return largest;
}

Vector3 inertia_less_weight(const NeedleModel& model, const NeedleScratch& scratch, const NeedleState& state) {
  Vector3 sum = Vector3::Zero();
  for (int i = 0; i < model.nodes(); ++i) sum += inertia_force(model, scratch, state, scratch.iterate, i).head<3>();
  return sum;
}

NeedleEnergyChange energy_change(const NeedleModel& model, const NeedleScratch& scratch, const NeedleState& state) {
  double kinetic = 0, work = 0;
  for (int i = 0; i < model.nodes(); ++i) {
    const Vector6 v = velocity(scratch, state, i);
    kinetic += kinetic_energy(model, i, scratch.iterate.shape.frames[i].col(0), v);
    const Vector6 force =
        i == 0 ? Vector6(scratch.reaction + scratch.on_base) : Vector6(scratch.applied.segment<6>(6 * (i - 1)));
    work += scratch.h * (force.dot(v) + model.mass[i] * model.gravity.dot(v.head<3>()));
  }
  const double stored = kinetic + elastic_energy(model, scratch.iterate.shape);
  const double stored_before = kinetic_energy(model, state) + elastic_energy(model, scratch.carried.shape);
  return {stored, stored - stored_before - work};
}

double largest_strain(const NeedleModel& model, const NeedleScratch& scratch) {
  double largest = 0;
  for (int e = 0; e < model.beams; ++e) {
    const auto [stiffness, a, b] = needle_beam(model, scratch.iterate.shape, e);
    const double stretch = std::abs((b.position - a.position).norm() / stiffness.length - 1);
    const double bend = (b.frame.col(0) - a.frame.col(0)).norm() / stiffness.length * model.diameter / 2;
    largest = std::max(largest, stretch + bend);
  }
  return largest;
}

void commit_needle(const NeedleScratch& scratch, NeedleState& state) {
  for (int i = 0; i < static_cast<int>(state.x.cols()); ++i) {
    state.v.col(i) = velocity(scratch, state, i);
    state.x.col(i) = scratch.iterate.shape.x.col(i);
    state.q[i] = scratch.iterate.q[i];
  }
}

}  // namespace acus
