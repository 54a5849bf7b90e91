// SPDX-License-Identifier: MIT
// The simulated handle and hand as a device: the hand inserts along the handle's x axis, rests, pulls back, rests,
// again and again.
#pragma once

#include <functional>

#include "client/haptics/device.h"
#include "client/haptics/simulated_handle.h"

namespace acus::haptics {

struct HandMotion {
  double depth = 0.04;  // m, > 0, way of the hand in and back
  double speed = 0.02;  // m/s, > 0
  double rest = 0.5;    // s, >= 0, before and after each way
};

// Where the hand means to be (m) and how fast it moves there (m/s), at a time (s) since it began.
struct Meant {
  double place = 0, speed = 0;
};
Meant meant_at(const HandMotion& motion, double time);

// What such a handle, as a device of this rate (Hz), tells of itself.
DeviceProperties told_of(const SimulatedHandleProperties& handle, double rate);

class SimulatedDevice : public Device {
 public:
  // `clock` tells s, and never goes back; the handle is simulated up to it at every reading.
  SimulatedDevice(const SimulatedHandleProperties& properties, double rate, const HandMotion& motion,
                  std::function<double()> clock);

  DeviceProperties open() override;
  Reading read() override;
  void write(const Wrench& wrench) override { handle_.write(wrench.force); }
  void close() override { handle_.write({}); }

  const SimulatedHandle& handle() const { return handle_; }

 private:
  SimulatedHandleProperties properties_;
  double rate_;
  HandMotion motion_;
  std::function<double()> clock_;
  SimulatedHandle handle_;
  double began_ = 0;
};

}  // namespace acus::haptics
