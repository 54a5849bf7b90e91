// SPDX-License-Identifier: MIT
// A factor that goes to zero and back to one in a straight line of time, for forces that must not end or begin at once.
#pragma once

#include <algorithm>

namespace acus::haptics {

class Ramp {
 public:
  explicit Ramp(double duration, double factor = 0) : duration_(duration), factor_(factor) {}  // s

  // One sample (s) later, on the way to one or to zero.
  double step(bool on, double sample_time) {
    const double way = duration_ > 0 ? sample_time / duration_ : 1;
    factor_ = std::clamp(factor_ + (on ? way : -way), 0.0, 1.0);
    return factor_;
  }
  double factor() const { return factor_; }

 private:
  double duration_;
  double factor_;
};

}  // namespace acus::haptics
