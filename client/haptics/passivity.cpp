// SPDX-License-Identifier: MIT
#include "client/haptics/passivity.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <stdexcept>
#include <string>

namespace acus::haptics {

int samples_of_delay(const DeviceProperties& properties) {
  const double samples = std::ceil(properties.delay * properties.rate - 1e-9);
  if (samples < Passivity::kMostDelay) return static_cast<int>(samples);
  throw std::invalid_argument("delay: expected less than " + std::to_string(Passivity::kMostDelay) +
                              " samples, found " + std::to_string(samples));
}

Passivity::Passivity(const Coupling& coupling, int delay) : delay_(delay) {
  assert(delay >= 0 && delay < kMostDelay);
  const double t = coupling.translation, r = coupling.rotation;
  stiffness_ = {{t, t, t, r, r, r}};
}

double Passivity::cost(const Vector6& wrench) const {
  double sum = 0;
  for (int i = 0; i < 6; ++i)
    if (stiffness_[i] > 0) sum += wrench[i] * wrench[i] / stiffness_[i] / 2;
  return sum;
}

void Passivity::observe(const Vector6& displacement, double periods) {
  const auto acted = static_cast<std::size_t>((newest_ - delay_ + kMostDelay) % kMostDelay);
  const double brought = dot(rendered_[acted], displacement);
  double eaten = 0;
  for (int i = 0; i < 6; ++i) eaten += (0.5 + delay_) * stiffness_[i] * displacement[i] * displacement[i];
  given_ += brought;
  withheld_ += std::max(0.0, dot(wanted_[acted], displacement) - brought);
  account_ += eaten / std::max(1.0, periods) - brought;
}

Wrench Passivity::control(const Wrench& wanted, double stored) {
  Vector6 wrench = joined(wanted);
  for (int i = 0; i < 6; ++i)
    if (!(stiffness_[i] > 0)) wrench[i] = 0;  // an axis that renders nothing
  newest_ = (newest_ + 1) % kMostDelay;
  wanted_[static_cast<std::size_t>(newest_)] = wrench;
  const double needed = cost(wrench);
  double share = 1;
  if (needed > 0 && needed > account_) share = std::sqrt(std::max(account_, 0.0) / needed);
  rendered_[static_cast<std::size_t>(newest_)] = share * wrench;
  const double reserve =
      kReserveShare * stored + (stiffness_[0] > 0 ? kReserveForce * kReserveForce / stiffness_[0] / 2 : 0);
  account_ = std::min(account_, std::max(stored, share * share * needed) + reserve);
  return wrench_of(rendered_[static_cast<std::size_t>(newest_)]);
}

}  // namespace acus::haptics
