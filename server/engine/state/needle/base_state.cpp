// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/state/needle/base_state.h"

#include "server/engine/math/rotation.h"

namespace acus {

namespace {

constexpr double kLeastTau = 1e-9;  // s; distances over shorter times may be no numbers

std::optional<double> used_tau(std::optional<double> smoothing) {
  if (smoothing && *smoothing < kLeastTau) return 0;
  return smoothing;
}

}  // namespace

BaseLimits base_limits(const Needle& p) {
  return {used_tau(p.smoothing), p.max_speed, p.max_angular_speed, p.max_spin_speed};
}

BaseLimits base_limits(const Guide& p) { return {used_tau(p.smoothing), p.max_speed, p.max_angular_speed, 0}; }

Pose BaseState::spun_pose() const {
  return {pose.position, (pose.orientation * rotation_exp({spin, 0, 0})).normalized()};
}

bool BaseState::is_finite() const {
  for (const Pose* p : {&pose, &target})
    if (!p->position.array().isFinite().all() || !p->orientation.coeffs().array().isFinite().all()) return false;
  return velocity.array().isFinite().all() && angular_velocity.array().isFinite().all() && std::isfinite(spin) &&
         std::isfinite(target_spin) && std::isfinite(spin_velocity) && rhythm.is_finite();
}

BaseState base_at(const Pose& pose) {
  BaseState base;
  base.pose = base.target = pose;
  return base;
}

}  // namespace acus
