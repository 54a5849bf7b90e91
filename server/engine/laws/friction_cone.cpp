// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/laws/friction_cone.h"

#include <algorithm>
#include <cmath>

namespace acus {

namespace {

constexpr double kSlope = 0.3;  // k (-)

// What a force that is the share x of the circle's radius leaves of it, across.
double rest_of_circle(double x) { return std::sqrt(std::max(0.0, (1 - x) * (1 + x))); }

// Of rows in which the ellipse is a circle, its half axis along being r.
ConeLaws friction(double r, double along, double along_viscosity, double about, double about_viscosity) {
  return {Law{LawKind::friction, r * along, r * r * along_viscosity}, Law{LawKind::friction, about, about_viscosity}};
}

}  // namespace

DiskContact cone_contact(const FrictionCone& cone, const Eigen::Matrix2d& W, const Eigen::Vector2d& delta_bar) {
  const DiskContact in = disk_contact(cone.law, W, delta_bar);
  const double stretch = cone.stretch(in.force[0]);
  return stretch == 1 ? in : disk_contact(cone.law, W, delta_bar, stretch);
}

ConeLaws laws_of_rows(const FrictionCone& cone, const DiskContact& contact) {
  const SlipLaw& law = cone.law;
  const double r = cone.stretch(contact.force[0]), T = law.threshold;
  const Eigen::Array2d axes(r, 1);
  const Eigen::Array2d slip = axes * contact.slip.array().abs(), force = contact.force.array() / axes;
  const double size = slip.matrix().norm();
  if (contact.slips && size > 0) {
    const double full = contact.slip.norm(), slope = law.slope(full);
    // The tangent, which meets the axis at a force that is not negative but for rounding.
    const double at_rest = std::max(law.force(full) - slope * full, 0.0), viscosity = slope * full / size;
    const Eigen::Array2d way = slip / size, across = kSlope * way.square().reverse();
    const Eigen::Array2d thresholds = at_rest * way * (1 - across), viscosities = at_rest / size * across + viscosity;
    return friction(r, thresholds[0], viscosities[0], thresholds[1], viscosities[1]);
  }
  const double c = law.viscosity;
  if (T == 0) return friction(r, 0, c / r, 0, c);
  return friction(r, T * rest_of_circle(force[1] / T), c / r, T * rest_of_circle(force[0] / T), c);
}

ConeLaws laws_of_disk(const FrictionCone& cone) {
  return {Law{.kind = LawKind::disk_first, .cone = &cone}, Law{.kind = LawKind::disk_second, .cone = &cone}};
}

}  // namespace acus
