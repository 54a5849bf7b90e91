// SPDX-License-Identifier: MIT
// The local model of a needle from the topic `force`, for servers that do not publish `haptics` (message.h).
//
// `force` has no stiffness. It is found as a secant: how much the axial force has changed over the last way
// of the base, kept while the base rests or the needle slides.
#pragma once

#include <array>

#include "client/haptics/message.h"
#include "protocol/messages.h"

namespace acus::haptics {

class ForceModel {
 public:
  LocalModel of(const protocol::Force& force);

 private:
  double secant(const LocalModel& model);

  struct Past {
    Vector3 position, force;
  };
  static constexpr int kTicks = 20;          // that a secant spans
  static constexpr double kShortest = 5e-6;  // m
  static constexpr double kStiffest = 1e6;   // N/m

  std::array<Past, kTicks> past_{};
  int next_ = 0, count_ = 0;
  double stiffness_ = 0;
};

}  // namespace acus::haptics
