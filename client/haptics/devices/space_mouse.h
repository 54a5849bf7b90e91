// SPDX-License-Identifier: MIT
// A SpaceMouse, through libspnav and the daemon spacenavd: the cap pushed away from the hand pushes the needle in,
// aside and up move it so, its turns turn it; any button is the clutch. No force.
#pragma once

#include <functional>
#include <utility>

#include "client/haptics/device.h"
#include "client/haptics/devices/rate_control.h"

namespace acus::haptics {

class SpaceMouse : public Device {
 public:
  SpaceMouse(double rate, std::function<double()> clock) : rate_(rate), clock_(std::move(clock)) {}
  ~SpaceMouse() override { close(); }

  DeviceProperties open() override;
  Reading read() override;
  void write(const Wrench&) override {}
  void close() override;

  static constexpr double kFull = 350;  // counts that spacenavd tells of a cap that is pushed to its end, about

 private:
  double rate_;
  std::function<double()> clock_;
  bool open_ = false, clutch_ = false;
  Deflection deflection_;
  RateControl control_;
};

}  // namespace acus::haptics
