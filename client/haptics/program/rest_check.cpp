// SPDX-License-Identifier: MIT
#include "client/haptics/program/rest_check.h"

#include <cmath>

namespace acus::haptics {

double RestCheck::Rest::difference() const { return std::abs(felt - server) / server; }

void RestCheck::begin(double now, const Vector3& handle) {
  began_ = now;
  handle_ = handle;
  sum_ = {};
  samples_ = 0;
}

void RestCheck::add(double now, const Vector3& handle, double felt, double server) {
  if (samples_ < 0 || norm(handle - handle_) > kStill) return begin(now, handle);
  if (now - began_ > kPeriod / 2) {
    sum_.felt += felt;
    sum_.server += server;
    ++samples_;
  }
  if (now - began_ < kPeriod || samples_ == 0) return;
  const Rest rest{sum_.felt / samples_, sum_.server / samples_};
  if (rest.server >= kLeastForce && (!worst_ || rest.difference() > worst_->difference())) worst_ = rest;
  begin(now, handle);
}

}  // namespace acus::haptics
