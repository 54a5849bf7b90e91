// SPDX-License-Identifier: MIT
// The devices that acus-haptic knows, by name.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "client/haptics/device.h"
#include "client/haptics/simulated_device.h"

namespace acus::haptics {

struct DeviceChoice {
  std::string name = "simulated";
  double rate = 1000;                            // Hz, of the loop
  SimulatedHandleProperties simulated;           // of the simulated device,
  HandMotion motion;                             // and its hand
  std::string address = "ws://127.0.0.1:10001";  // of the service of the Inverse3
  std::function<double()> clock;                 // s
};

// Those that this build can open.
std::vector<std::string> device_names();

// Throws DeviceError for a name that is none of them.
std::unique_ptr<Device> make_device(const DeviceChoice& choice);

}  // namespace acus::haptics
