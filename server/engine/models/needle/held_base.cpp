// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/models/needle/held_base.h"

#include "server/engine/math/rotation.h"

namespace acus {

namespace {

// How far a holder is from a base: (translation, rotation), world.
Pose apart(const Pose& holder, const Pose& base) {
  return {holder.position - base.position, holder.orientation * base.orientation.conjugate()};
}

}  // namespace

void HeldBase::begin(const Pose& holder_before, const Pose& holder, const Pose& base) {
  before_ = holder_before;
  holder_ = holder;
  base_ = base;
}

Pose HeldBase::carried_along() const {
  const Quaternion turn = holder_.orientation * before_.orientation.conjugate();
  return {holder_.position + turn * (base_.position - before_.position), (turn * base_.orientation).normalized()};
}

Vector6 HeldBase::wrench(const Pose& base) const {
  const Pose start = apart(before_, base_), end = apart(holder_, base);
  const Vector3 slipped = end.position - start.position;
  const Vector3 turned = rotation_log(end.orientation * start.orientation.conjugate());
  Vector6 wrench;
  wrench << hold_.stiffness * end.position + hold_.damping / h_ * slipped,
      hold_.angular_stiffness * rotation_log(end.orientation) + hold_.angular_damping / h_ * turned;
  return wrench;
}

Vector6 HeldBase::tangent() const {
  Vector6 tangent;
  tangent << Vector3::Constant(hold_.stiffness + hold_.damping / h_),
      Vector3::Constant(hold_.angular_stiffness + hold_.angular_damping / h_);
  return tangent;
}

}  // namespace acus
