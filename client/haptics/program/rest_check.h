// SPDX-License-Identifier: MIT
// Whether the force that is felt at rest is the server's. While the hand holds still nothing but the tissue acts on the
// needle, and both have to agree, but for what the device's largest force and the passivity controller take away.
#pragma once

#include <optional>

#include "client/haptics/vectors.h"

namespace acus::haptics {

class RestCheck {
 public:
  static constexpr double kPeriod = 0.25;     // s, of rest
  static constexpr double kStill = 50e-6;     // m, that the handle may move in it
  static constexpr double kLeastForce = 0.1;  // N, of the server
  static constexpr double kDifference = 0.1;  // -, above which the two differ

  // Means over the second half of a period of rest (N, at the device).
  struct Rest {
    double felt = 0, server = 0;
    double difference() const;
  };

  // A sample: s, m, N.
  void add(double now, const Vector3& handle, double felt, double server);

  // The period with the largest difference; none if there was no rest with a force.
  const std::optional<Rest>& worst() const { return worst_; }
  bool differs() const { return worst_ && worst_->difference() > kDifference; }

 private:
  void begin(double now, const Vector3& handle);

  double began_ = 0;
  Vector3 handle_;
  Rest sum_;
  int samples_ = -1;  // -1: not begun
  std::optional<Rest> worst_;
};

}  // namespace acus::haptics
