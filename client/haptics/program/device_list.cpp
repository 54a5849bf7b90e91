// SPDX-License-Identifier: MIT
#include "client/haptics/program/device_list.h"

#ifdef ACUS_WITH_SDL
#include "client/haptics/devices/gamepad.h"
#endif
#ifdef ACUS_WITH_SPNAV
#include "client/haptics/devices/space_mouse.h"
#endif
#ifdef ACUS_WITH_INVERSE3
#include "client/haptics/devices/inverse3.h"
#endif

namespace acus::haptics {

std::vector<std::string> device_names() {
  std::vector<std::string> names{"simulated"};
#ifdef ACUS_WITH_SDL
  names.emplace_back("gamepad");
#endif
#ifdef ACUS_WITH_SPNAV
  names.emplace_back("spacemouse");
#endif
#ifdef ACUS_WITH_INVERSE3
  names.emplace_back("inverse3");
#endif
  return names;
}

std::unique_ptr<Device> make_device(const DeviceChoice& choice) {
  if (choice.name == "simulated")
    return std::make_unique<SimulatedDevice>(choice.simulated, choice.rate, choice.motion, choice.clock);
#ifdef ACUS_WITH_SDL
  if (choice.name == "gamepad") return std::make_unique<Gamepad>(choice.rate, choice.clock);
#endif
#ifdef ACUS_WITH_SPNAV
  if (choice.name == "spacemouse") return std::make_unique<SpaceMouse>(choice.rate, choice.clock);
#endif
#ifdef ACUS_WITH_INVERSE3
  if (choice.name == "inverse3") return std::make_unique<Inverse3>(choice.address, choice.rate);
#endif
  throw DeviceError("device '" + choice.name + "' is not known to this build; acus-haptic --help lists those that are");
}

}  // namespace acus::haptics
