// SPDX-License-Identifier: MIT
// A tissue with a closed form, along one line, for tests and for trying out devices without a server: a spring to the
// surface until the puncture force, then a spring that yields at the force of cutting and friction.
//
//   before:  F = -k (x - surface) for x > surface; at F = -puncture it opens
//   after:   F = -k e, |e| <= yield/k: the spring's deflection e follows x; it yields ahead at cutting + friction,
//            back at friction alone
//
// The needle's base moves along the world's x axis, as its own +x.
#pragma once

#include "client/haptics/local_model.h"

namespace acus::haptics {

class AnalyticTissue {
 public:
  struct Properties {
    double stiffness = 300;  // N/m, > 0
    double puncture = 1;     // N, > 0
    double cutting = 0.5;    // N, >= 0
    double friction = 0.3;   // N, >= 0
    double surface = 0.01;   // m
  };

  explicit AnalyticTissue(const Properties& properties) : properties_(properties) {}

  // The tick in which the base has come to x (m).
  void step(double x);
  LocalModel model() const;
  double force() const { return force_; }  // N, along x
  bool punctured() const { return punctured_; }

 private:
  Properties properties_;
  bool punctured_ = false;
  bool yields_ = false;
  std::uint64_t tick_ = 0;
  double x_ = 0, anchor_ = 0;  // m, anchor: where the spring is at rest
  double force_ = 0;
};

}  // namespace acus::haptics
