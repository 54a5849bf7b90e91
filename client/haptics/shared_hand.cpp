// SPDX-License-Identifier: MIT
#include "client/haptics/shared_hand.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "client/haptics/limits.h"

namespace acus::haptics {

namespace {

DeviceProperties checked(const DeviceProperties& properties, const SharedHandOptions& options) {
  validate(properties);
  if (!(options.stiffness >= 0 && std::isfinite(options.stiffness)))
    throw std::invalid_argument("stiffness: expected >= 0, found " + std::to_string(options.stiffness));
  if (!(options.force_growth > 0))
    throw std::invalid_argument("force_growth: expected > 0, found " + std::to_string(options.force_growth));
  if (!(options.ramp >= 0)) throw std::invalid_argument("ramp: expected >= 0, found " + std::to_string(options.ramp));
  return properties;
}

}  // namespace

SharedHand::SharedHand(const DeviceProperties& properties, const SharedHandOptions& options)
    : properties_(checked(properties, options)),
      options_(options),
      coupling_(coupling_of(properties)),
      passivity_(coupling_, samples_of_delay(properties)),
      stiffness_(std::min(options.stiffness, coupling_.translation / 2)),
      turning_(coupling_.translation > 0 ? stiffness_ * coupling_.rotation / coupling_.translation : 0),
      ramp_(options.ramp) {}

Vector6 SharedHand::spring(const Vector6& ahead) const {
  Vector6 wrench;
  for (int i = 0; i < 6; ++i) wrench[i] = (i < 3 ? stiffness_ : turning_) * ahead[i];
  return wrench;
}

Wrench SharedHand::step(double elapsed, const Vector6& moved, const Wrench& felt, double stored, double share,
                        const std::optional<Vector6>& ahead) {
  passivity_.observe(moved, elapsed * properties_.rate);
  if (ahead) ahead_ = *ahead;
  const double factor = ramp_.step(ahead.has_value(), std::max(1 / properties_.rate, elapsed));
  const Vector6 between = factor * spring(ahead_);
  const Wrench wanted = within_limits(before_, wrench_of(share * joined(felt) + between), properties_,
                                      options_.force_growth / properties_.rate, properties_.translation.largest_force);
  return before_ = passivity_.control(wanted, share * stored + dot(between, ahead_) / 2);
}

}  // namespace acus::haptics
