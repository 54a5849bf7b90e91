// SPDX-License-Identifier: MIT
// A haptic device is four functions. To add one, derive from Device and give it a name in device_list.cpp.
#pragma once

#include <stdexcept>

#include "client/haptics/coupling.h"
#include "client/haptics/vectors.h"

namespace acus::haptics {

// The device is not there, or stopped answering; what() says which and why.
struct DeviceError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

class Device {
 public:
  struct Reading {
    Pose pose;            // of the handle, in the device's own frame, m
    bool clutch = false;  // held down: the handle moves, the needle rests
  };

  virtual ~Device() = default;

  // Connects, and tells what the coupling has to know. Throws DeviceError.
  virtual DeviceProperties open() = 0;
  // Where the handle is now, without waiting. Throws DeviceError.
  virtual Reading read() = 0;
  // The wrench on the handle until the next one, in the device's frame; a device does what it can of it.
  virtual void write(const Wrench& wrench) = 0;
  // Lets the handle go: no force is left. Never throws; may be called twice.
  virtual void close() = 0;
};

}  // namespace acus::haptics
