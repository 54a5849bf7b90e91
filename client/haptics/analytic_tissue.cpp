// SPDX-License-Identifier: MIT
#include "client/haptics/analytic_tissue.h"

#include <algorithm>

namespace acus::haptics {

void AnalyticTissue::step(double x) {
  const Properties& p = properties_;
  ++tick_;
  x_ = x;
  yields_ = false;
  if (!punctured_) {
    force_ = -p.stiffness * std::max(x - p.surface, 0.0);
    if (force_ > -p.puncture) return;
    punctured_ = true;
    anchor_ = x - (p.cutting + p.friction) / p.stiffness;
    force_ = -(p.cutting + p.friction);
    return;
  }
  const double most = (p.cutting + p.friction) / p.stiffness, least = -p.friction / p.stiffness;
  const double deflection = std::clamp(x - anchor_, least, most);
  yields_ = deflection != x - anchor_;
  anchor_ = x - deflection;
  force_ = -p.stiffness * deflection;
}

LocalModel AnalyticTissue::model() const {
  const Properties& p = properties_;
  LocalModel model;
  model.tick = tick_;
  model.base.position[0] = x_;
  model.felt.force[0] = force_;
  const bool touches = punctured_ || x_ > p.surface;
  if (!touches) return model;
  if (!yields_) model.stiffness(0, 0) = -p.stiffness;
  const double ahead = punctured_ ? p.cutting + p.friction : p.puncture, back = punctured_ ? p.friction : 0;
  model.forward = std::clamp((ahead + force_) / p.stiffness, 0.0, 1.0);
  model.backward = std::clamp((back - force_) / p.stiffness, 0.0, 1.0);
  model.forward_limit = punctured_ ? Limit::cutting : Limit::puncture;
  model.backward_limit = punctured_ ? Limit::slip : Limit::contact;
  return model;
}

}  // namespace acus::haptics
