// SPDX-License-Identifier: MIT
#include "client/haptics/simulated_device.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace acus::haptics {

Meant meant_at(const HandMotion& motion, double time) {
  const double way = motion.depth / motion.speed;
  const double t = std::fmod(time, 2 * (way + motion.rest));
  if (t < motion.rest) return {0, 0};
  if (t < motion.rest + way) return {motion.speed * (t - motion.rest), motion.speed};
  if (t < 2 * motion.rest + way) return {motion.depth, 0};
  return {motion.depth - motion.speed * (t - 2 * motion.rest - way), -motion.speed};
}

SimulatedDevice::SimulatedDevice(const SimulatedHandleProperties& properties, double rate, const HandMotion& motion,
                                 std::function<double()> clock)
    : properties_(properties), rate_(rate), motion_(motion), clock_(std::move(clock)), handle_(properties) {}

DeviceProperties SimulatedDevice::open() {
  began_ = clock_();
  return told_of(properties_, rate_);
}

DeviceProperties told_of(const SimulatedHandleProperties& handle, double rate) {
  DeviceProperties properties;
  properties.translation = handle.axis;
  properties.rate = rate;
  properties.delay = handle.delay.delay + handle.delay.jitter;
  return properties;
}

Device::Reading SimulatedDevice::read() {
  constexpr double kHandStep = 1e-3;  // s, in which the hand means one thing
  const double until = clock_() - began_;
  while (handle_.now() < until - 1e-9) {
    const Meant meant = meant_at(motion_, handle_.now());
    handle_.mean({{meant.place, 0, 0}}, {{meant.speed, 0, 0}});
    handle_.advance(std::min(kHandStep, until - handle_.now()));
  }
  return {{handle_.measured(), {}}, false};
}

}  // namespace acus::haptics
