// SPDX-License-Identifier: MIT
// The simulated handle with a hand that does what a verification asks for.
#pragma once

#include <algorithm>
#include <functional>
#include <utility>

#include "client/haptics/device.h"
#include "client/haptics/simulated_handle.h"

namespace acus::haptics {

class ObedientDevice : public Device {
 public:
  ObedientDevice(const SimulatedHandleProperties& handle, const DeviceProperties& properties,
                 std::function<double()> clock)
      : properties_(properties), clock_(std::move(clock)), handle_(handle) {}

  // By so much from where the hand means to be (m).
  void request(const Vector3& way) { goal_ += way; }

  DeviceProperties open() override {
    began_ = clock_();
    return properties_;
  }
  Reading read() override {
    constexpr double kSpeed = 0.1;  // m/s
    for (const double until = clock_() - began_; handle_.now() < until - 1e-9;) {
      const double step = std::min(1e-3, until - handle_.now());
      const Vector3 left = goal_ - meant_;
      const double length = norm(left), way = std::min(kSpeed * step, length);
      const Vector3 moved = length > 0 ? way / length * left : Vector3{};
      meant_ += moved;
      handle_.mean(meant_, 1 / step * moved);
      handle_.advance(step);
    }
    return {{handle_.measured(), {}}, false};
  }
  void write(const Wrench& wrench) override { handle_.write(wrench.force); }
  void close() override { handle_.write({}); }

 private:
  DeviceProperties properties_;
  std::function<double()> clock_;
  SimulatedHandle handle_;
  Vector3 goal_, meant_;
  double began_ = 0;
};

}  // namespace acus::haptics
