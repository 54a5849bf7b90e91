// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/laws/friction_cone.h"

#include <algorithm>
#include <cmath>

namespace acus {

namespace {

// What a force that is the share x of the circle's radius leaves of it, across.
double rest_of_circle(double x) { return std::sqrt(std::max(0.0, (1 - x) * (1 + x))); }

Law friction(double threshold, double viscosity) { return {LawKind::friction, threshold, viscosity}; }

}  // namespace

ConeLaws laws_of_rows(const FrictionCone& cone, const DiskContact& contact, double slope) {
  const double T = cone.threshold, c = cone.viscosity, size = contact.slip.norm();
  if (contact.slips && size > 0) {
    const Eigen::Array2d way = contact.slip.array().abs() / size;
    const Eigen::Array2d across = slope * way.square().reverse();
    return {friction(T * way[0] * (1 - across[0]), T / size * across[0] + c),
            friction(T * way[1] * (1 - across[1]), T / size * across[1] + c)};
  }
  if (T == 0) return {friction(0, c), friction(0, c)};
  return {friction(T * rest_of_circle(contact.force[1] / T), c), friction(T * rest_of_circle(contact.force[0] / T), c)};
}

ConeLaws laws_of_disk(const FrictionCone& cone) {
  const Law first{.kind = LawKind::disk_first, .viscosity = cone.viscosity, .cohesion = cone.threshold};
  Law second = first;
  second.kind = LawKind::disk_second;
  return {first, second};
}

}  // namespace acus
