// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/laws/friction_cone.h"

#include <algorithm>
#include <cmath>

namespace acus {

DiskContact cone_contact(const FrictionCone& cone, const Eigen::Matrix2d& W, const Eigen::Vector2d& delta_bar,
                         const Eigen::Vector2d& near) {
  const DiskContact in = disk_contact(cone.law, W, delta_bar, 1, near);
  const double stretch = cone.stretch(in.force[0]);
  return stretch == 1 ? in : disk_contact(cone.law, W, delta_bar, stretch, near);
}

double cone_force(const FrictionCone& cone, double compliance, double delta_bar) {
  return cone_contact(cone, compliance * Eigen::Matrix2d::Identity(), {delta_bar, 0}).force[0];
}

ConeTangent cone_tangent(const FrictionCone& cone, const DiskContact& contact, double compliance) {
  if (!contact.slips) return {};
  // In axes in which the ellipse is a circle.
  const Eigen::Vector2d axes(cone.stretch(contact.force[0]), 1);
  const Eigen::Vector2d force = contact.force.cwiseQuotient(axes);
  const double radius = force.norm(), size = axes.cwiseProduct(contact.slip).norm(), full = contact.slip.norm();
  const double least = 1 / (kSteepest * compliance);
  const double rise = std::max(cone.law.slope(full) * (size > 0 ? full / size : 1), least);
  ConeTangent tangent{.slips = true};
  if (radius > 0) {
    const Eigen::Vector2d way = force / radius;
    const double across = size / radius;
    tangent.give = (1 / rise - across) * (way * way.transpose());
    tangent.give.diagonal().array() += across;
  } else {
    tangent.give.diagonal().setConstant(1 / rise);
  }
  const Eigen::Vector2d back = axes.cwiseInverse();
  tangent.give.array() *= (back * back.transpose()).array();
  tangent.offset = contact.slip + tangent.give * contact.force;
  return tangent;
}

std::array<Law, 2> laws_of_disk(const FrictionCone& cone) {
  return {Law{.kind = LawKind::disk_first, .cone = &cone}, Law{.kind = LawKind::disk_second, .cone = &cone}};
}

}  // namespace acus
