// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/simulation/insertion/tip_give.h"

namespace acus {

double surface_compliance(const InsertionView& at, const Obstacle& obstacle) {
  return at.tissue.surface_compliance(obstacle.material, at.parameters.outer_diameter);
}

double cutting_compliance(const InsertionView& at, const Path& path) {
  return at.tissue.tip_compliance(path.end, at.parameters.outer_diameter,
                                  at.tissue.interaction(path.end).cutting_force);
}

double hold_compliance(const InsertionView& at, const TipPlace& place) {
  const double d = at.needle.model.diameter;
  const double end = 1 / at.tissue.end_compliance(place.point.a, d);
  return 1 / (end + place.held / at.tissue.lateral_compliance(place.point.a, d));
}

double border_compliance(const InsertionView& at, const Path& path, double contact) {
  const double flat = at.tissue.interaction(path.end).cutting_force;
  return cutting_compliance(at, path) * (contact > flat ? flat / contact : 1);
}

}  // namespace acus
