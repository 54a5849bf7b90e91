// SPDX-License-Identifier: GPL-3.0-or-later
// What is inside the shapes of a scene.
#include "server/engine/scene/scene.h"

namespace acus {

bool Box::contains(const Vector3& p, double margin) const {
  return (p.array() >= min.array() - margin).all() && (p.array() <= max.array() + margin).all();
}

bool Sphere::contains(const Vector3& p, double margin) const { return (p - center).norm() <= radius + margin; }

bool HalfSpace::contains(const Vector3& p, double margin) const {
  return (p - point).dot(normal.normalized()) <= margin;
}

bool Cylinder::contains(const Vector3& p, double margin) const {
  const Vector3 axis = (to - from).normalized();
  const double along = (p - from).dot(axis);
  const double across = (p - from - along * axis).norm();
  return along >= -margin && along <= (to - from).norm() + margin && across <= radius + margin;
}

bool Volume::contains(const Vector3& p, double margin) const {
  return (!box || box->contains(p, margin)) && (!sphere || sphere->contains(p, margin)) &&
         (!half_space || half_space->contains(p, margin)) && (!cylinder || cylinder->contains(p, margin));
}

}  // namespace acus
