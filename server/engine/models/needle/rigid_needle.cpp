// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/models/needle/rigid_needle.h"

#include "server/engine/math/rotation.h"

namespace acus {

Vector6 about_base(const NeedleScratch& scratch, int node, const Vector6& wrench) {
  const Vector3 arm = scratch.iterate.shape.x.col(node) - scratch.iterate.shape.x.col(0), force = wrench.head<3>();
  Vector6 moved = wrench;
  moved.tail<3>() += arm.cross(force);
  return moved;
}

Vector3 step_of_tip(const NeedleScratch& scratch) {
  const Vector3 arm = scratch.iterate.shape.x.rightCols<1>() - scratch.iterate.shape.x.col(0);
  return scratch.base_step.head<3>() + scratch.base_step.tail<3>().cross(arm);
}

void turn_about_base(const NeedleModel& model, const NeedleScratch& scratch, double share, NeedleConfiguration& to) {
  const Vector6 step = share * scratch.base_step;
  const Quaternion turn = rotation_exp(step.tail<3>());
  const Vector3 pivot = scratch.iterate.shape.x.col(0);
  for (int i = 0; i < model.nodes(); ++i) {
    to.shape.x.col(i) = pivot + step.head<3>() + turn * (scratch.iterate.shape.x.col(i) - pivot);
    to.q[i] = (turn * scratch.iterate.q[i]).normalized();
    to.shape.frames[i] = to.q[i].toRotationMatrix();
  }
}

}  // namespace acus
