// SPDX-License-Identifier: MIT
// How much of a tick's stiffness is not felt over a longer time.
//
// The stiffness of a tick says what its force would have been had the base gone further within that tick. Inertia and
// viscosity have their full share in it: a steel needle of 1 g resists a way within 1 ms with m/h² = 1,000 N/m in free
// air. Where the device is ahead of the base by the delay of a network, that way has more than a tick, and the needle
// resists with much less. So the stiffness that the last such way has really met is compared with what its ticks had
// told:
//
//   k_moving = max(0, (sum of k_i dp_i - (F_then - F_now))/(p_now - p_then)),   axial, p_then as far back as the newest
//                                                            command is ahead, or as the needle has been held
//
// and is taken off the tick's. A tick without any limit has no law that holds the needle: all of its stiffness is of
// this kind. A tip that leaves a surface for a few ticks comes back to the same surface, and finds what it was known
// for. What is rigid from one tick to the next, as bone that the tip comes upon, stays rigid.
#pragma once

#include <array>

#include "client/haptics/local_model.h"

namespace acus::haptics {

class MovingStiffness {
 public:
  // A model that came, with its axial stiffness (N/m, >= 0). `ahead` (m) is how far the newest command is from its
  // base, along its axis.
  void add(const LocalModel& model, double stiffness, double ahead);

  double value() const { return value_; }  // k_moving, N/m
  // Whether a tick of this stiffness is held by nothing but its own inertia, as in free air: if it bears a force it
  // slides.
  bool slides(double stiffness) const { return stiffness <= 1.05 * free_; }
  // The least stiffness that a way has met while the tip touched the surface, N/m; 0 if none yet, and in air. Once the
  // tip is inside, where a way slides as well, only ways on which the force grew count, if they met more: a stiffer
  // tissue. What would be deflected deeper than kDeepest is no spring.
  double softest() const { return softest_; }
  void forget() { count_ = free_ticks_ = 0, value_ = free_ = softest_ = 0; }

  // A shorter way tells nothing (m), nor do fewer ticks where there are more.
  static constexpr double kShortest = 20e-6;
  static constexpr int kTicks = 20;
  static constexpr double kDeepest = 5e-3;  // m

 private:
  struct Past {
    Vector3 position, force;
    double stiffness = 0;
    bool free = true;  // no law held the needle
  };
  static constexpr int kKept = 256;

  void learn_softest(double met, bool touches, double force_then, double force_now);

  std::array<Past, kKept> past_{};  // round
  int newest_ = 0, count_ = 0;
  int free_ticks_ = 0;  // in a row
  double value_ = 0;
  double softest_ = 0;
  double free_ = 0;  // N/m, of the last tick without a law
};

}  // namespace acus::haptics
