// SPDX-License-Identifier: MIT
#include "client/haptics/devices/space_mouse.h"

#include <spnav.h>

namespace acus::haptics {

DeviceProperties SpaceMouse::open() {
  if (spnav_open() == -1) throw DeviceError("spacemouse: spacenavd does not answer; is it running?");
  open_ = true;
  return without_force(rate_);
}

Device::Reading SpaceMouse::read() {
  spnav_event event{};
  while (spnav_poll_event(&event) != 0) {
    if (event.type == SPNAV_EVENT_MOTION) {
      const spnav_event_motion& m = event.motion;
      // libspnav: x to the right, y up, z away from the hand. Here: x away from the hand, y to the left, z up.
      deflection_.translation = 1 / kFull * Vector3{{double(m.z), double(-m.x), double(m.y)}};
      deflection_.rotation = 1 / kFull * Vector3{{double(m.rz), double(-m.rx), double(m.ry)}};
    } else if (event.type == SPNAV_EVENT_BUTTON) {
      clutch_ = event.button.press != 0;
    }
  }
  return {control_.step(deflection_, clock_()), clutch_};
}

void SpaceMouse::close() {
  if (!open_) return;
  spnav_close();
  open_ = false;
}

}  // namespace acus::haptics
