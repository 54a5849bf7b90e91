// SPDX-License-Identifier: MIT
// A gamepad, or what SDL 2 takes for one: the left stick pushes the needle in and back (forward, back) and aside, the
// right stick up and down and turns it; the lower face button (A) is the clutch. No force.
#pragma once

#include <functional>
#include <memory>

#include "client/haptics/device.h"

namespace acus::haptics {

class Gamepad : public Device {
 public:
  Gamepad(double rate, std::function<double()> clock);
  ~Gamepad() override;

  DeviceProperties open() override;
  Reading read() override;
  void write(const Wrench&) override {}
  void close() override;

 private:
  struct Hardware;
  std::unique_ptr<Hardware> hardware_;
  double rate_;
  std::function<double()> clock_;
};

}  // namespace acus::haptics
