// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/tick/insertion/tip_compliance.h"

#include <algorithm>

namespace acus {

double cutting_compliance(const InsertionView& at, const Path& path, double ahead) {
  const double cutting_force = at.tissue.interaction(path.end).cutting_force;
  const double free = at.tissue.tip_compliance(path.end, at.parameters.outer_diameter, cutting_force);
  return cutting_force > 0 ? std::min(free, std::max(0.0, ahead) / cutting_force) : free;
}

double hold_compliance(const InsertionView& at, const MaterialPoint& material, double held) {
  const double d = at.needle.model.diameter;
  const double end = 1 / at.tissue.end_compliance(material, d);
  return 1 / (end + held / at.tissue.lateral_compliance(material, d));
}

double distance_ahead(const InsertionView& at, const Obstacle& obstacle, const Vector3& tip, const Vector3& place) {
  constexpr double kGrazing = 1e-3;  // sine of the angle below which the way does not lead there
  const double towards = -obstacle.at.normal.dot(at.cutting_direction());
  return towards > kGrazing ? obstacle.at.normal.dot(tip - place) / towards : kInfinity;
}

}  // namespace acus
