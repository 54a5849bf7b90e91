// SPDX-License-Identifier: MIT
#pragma once

#include "client/haptics/device.h"

namespace acus::haptics {

// Closes a device, however the session ends.
class Opened {
 public:
  explicit Opened(Device& device) : device_(device) {}
  ~Opened() { device_.close(); }
  Opened(const Opened&) = delete;
  Opened& operator=(const Opened&) = delete;

 private:
  Device& device_;
};

}  // namespace acus::haptics
