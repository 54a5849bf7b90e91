// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/models/needle/needle_base.h"

#include <cassert>

#include "server/engine/models/needle/needle_terms.h"
#include "server/engine/models/needle/rigid_needle.h"

namespace acus {

namespace {

// How the base follows what holds it, (S + K)⁻¹ K.
Matrix6 share_of_holder(const NeedleScratch& scratch) {
  return scratch.base_factor.solve(Matrix6(scratch.held->tangent().asDiagonal()));
}

void follow_node(const NeedleModel& model, const NeedleScratch& scratch, Eigen::Ref<MatrixX> dq) {
  if (model.rigid) return;
  dq.setZero();
  dq.topRows<6>() = -scratch.base_coupling.transpose();
  for (int axis = 0; axis < 6; ++axis) {
    scratch.matrix.forward(dq.col(axis));
    scratch.matrix.backward(dq.col(axis));
  }
}

Matrix6 tangent_beside(const NeedleModel& model, const NeedleScratch& scratch, const Eigen::Ref<const MatrixX>& dq) {
  Matrix6 tangent = node_tangent(model, scratch);
  if (!model.rigid) tangent.noalias() += scratch.base_coupling * dq.topRows<6>();
  return tangent;
}

}  // namespace

Matrix6 node_tangent(const NeedleModel& model, const NeedleScratch& scratch) {
  Matrix6 tangent = Matrix6::Zero();
  if (!model.rigid) {
    tangent = scratch.base_diagonal;
    add_inertia_tangent(model, scratch, 0, tangent);
    return tangent;
  }
  for (int i = 0; i < model.nodes(); ++i) {
    Matrix6 of_node = Matrix6::Zero(), moved;
    add_inertia_tangent(model, scratch, i, of_node);
    for (int axis = 0; axis < 6; ++axis) moved.col(axis) = about_base(scratch, i, of_node.col(axis));
    for (int axis = 0; axis < 6; ++axis) tangent.row(axis) += about_base(scratch, i, moved.row(axis).transpose());
  }
  return tangent;
}

bool close_at_base(const NeedleModel& model, NeedleScratch& scratch) {
  follow_node(model, scratch, scratch.follow);
  Matrix6 stiffness = tangent_beside(model, scratch, scratch.follow);
  stiffness.diagonal() += scratch.held->tangent();
  scratch.base_factor.compute(stiffness);
  if (scratch.base_factor.info() != Eigen::Success) return false;
  Vector6 reaction = scratch.g.col(0);
  if (!model.rigid) reaction += scratch.base_coupling * scratch.dq_free.head<6>();
  scratch.base_free = scratch.base_factor.solve(scratch.held->wrench(scratch.iterate.base()) - reaction);
  scratch.dq_free.noalias() += scratch.follow * scratch.base_free;
  return true;
}

Vector6 follow_node(const NeedleModel& model, const NeedleScratch& scratch, int row,
                    const Eigen::Ref<const MatrixX>& dq) {
  const auto& [beam, force] = scratch.rows[row];
  if (model.rigid) return about_base(scratch, beam, force.head<6>()) + about_base(scratch, beam + 1, force.tail<6>());
  const Vector6 far = dq.middleRows<6>(6 * beam).transpose() * force.tail<6>();
  if (beam == 0) return far + force.head<6>();
  return far + dq.middleRows<6>(6 * (beam - 1)).transpose() * force.head<6>();
}

void follow_base(const NeedleModel& model, const NeedleScratch& scratch, Eigen::Ref<MatrixX> dq) {
  assert(dq.rows() == scratch.dq.size() && dq.cols() == 6);
  if (!scratch.held) return follow_node(model, scratch, dq);
  const Matrix6 share = share_of_holder(scratch);
  dq.noalias() = scratch.follow.lazyProduct(share);
}

Vector6 follow_base(const NeedleModel& model, const NeedleScratch& scratch, int row,
                    const Eigen::Ref<const MatrixX>& dq) {
  if (!scratch.held) return follow_node(model, scratch, row, dq);
  return share_of_holder(scratch).transpose() * follow_node(model, scratch, row, scratch.follow);
}

Matrix6 base_tangent(const NeedleModel& model, const NeedleScratch& scratch, const Eigen::Ref<const MatrixX>& dq) {
  if (!scratch.held) return tangent_beside(model, scratch, dq);
  const Matrix6 stiffness = scratch.held->tangent().asDiagonal();
  return stiffness - stiffness * share_of_holder(scratch);
}

Vector6 lasting_wrench(const NeedleModel& model, const NeedleScratch& scratch) {
  Vector6 sum = scratch.on_base;
  for (int i = 0; i < model.nodes(); ++i) {
    Vector6 force = Vector6::Zero();
    if (i > 0 && !model.rigid) force = scratch.applied.segment<6>(6 * (i - 1));
    force.head<3>() += model.mass[i] * model.gravity;
    sum += about_base(scratch, i, force);
  }
  return sum;
}

}  // namespace acus
