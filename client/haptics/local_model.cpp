// SPDX-License-Identifier: MIT
#include "client/haptics/local_model.h"

#include <algorithm>

namespace acus::haptics {

double LocalModel::axial_stiffness() const {
  const Vector3 axis = base.orientation * Vector3{{1, 0, 0}};
  double sum = 0;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) sum -= axis[i] * stiffness(i, j) * axis[j];
  return std::max(sum, 0.0);
}

void LocalModel::put_limits(double forward_yield, double backward_yield, bool cuts) {
  const double held = axial_stiffness();
  const double resistance = -dot(base.orientation * Vector3{{1, 0, 0}}, felt.force);
  const auto way = [held](double force) { return held > 0 ? std::clamp(force / held, 0.0, 1.0) : 1; };
  forward = backward = 1;
  forward_change = backward_change = 0;
  forward_limit = backward_limit = Limit::none;
  if (!(forward_yield > 0)) return;
  forward_change = std::max(forward_yield - resistance, 0.0);
  backward_change = std::max(backward_yield + resistance, 0.0);
  forward = way(forward_change);
  backward = way(backward_change);
  if (backward_yield > 0) {
    forward_limit = cuts ? Limit::cutting : Limit::slip;
    backward_limit = Limit::slip;
  } else {
    forward_limit = Limit::puncture;
    backward_limit = Limit::contact;
  }
}

}  // namespace acus::haptics
