// SPDX-License-Identifier: MIT
// A short force on top of what is felt, as the needle goes through a surface or leaves it: one period of a sine along
// the needle,
//
//   F(t) = height sin(2 pi t/length),  0 <= t < length,
//
// ahead first, as a tissue that lets go does, without an impulse in all. It gives back the sharpness that a device of
// limited stiffness cannot render, as event-based haptics does (Kuchenbecker, Fiene and Niemeyer 2006, IEEE Trans.
// Visualization and Computer Graphics 12(2); Fiene and Kuchenbecker 2007, World Haptics Conference).
#pragma once

#include <cmath>
#include <numbers>

namespace acus::haptics {

struct TransientShape {
  double height = 0;     // N, >= 0, at the device; 0: none
  double length = 0.01;  // s, > 0, at least kLeastSamples of the device
};

class Transient {
 public:
  // Fewer make no period.
  static constexpr int kLeastSamples = 4;

  explicit Transient(const TransientShape& shape = {}) : shape_(shape), time_(shape.length) {}

  void begin() { time_ = 0; }
  bool acts() const { return shape_.height > 0 && time_ < shape_.length; }
  // N, ahead, for the next sample: at its middle. Then time goes on.
  double step(double sample_time) {
    if (!acts()) return 0;
    const double at = time_ + sample_time / 2;
    time_ += sample_time;
    if (at >= shape_.length) return 0;  // a late sample
    return shape_.height * std::sin(2 * std::numbers::pi * at / shape_.length);
  }
  double height() const { return shape_.height; }

 private:
  TransientShape shape_;
  double time_;  // s since it began
};

}  // namespace acus::haptics
