// SPDX-License-Identifier: GPL-3.0-or-later
// The gamepad, on a joystick that SDL itself pretends.
#include "client/haptics/devices/gamepad.h"

#include <SDL.h>
#include <doctest/doctest.h>

using namespace acus::haptics;

namespace {

// A gamepad that only SDL knows of, for as long as it lives.
struct VirtualGamepad {
  VirtualGamepad() {
    SDL_SetHint(SDL_HINT_JOYSTICK_ALLOW_BACKGROUND_EVENTS, "1");
    REQUIRE(SDL_InitSubSystem(SDL_INIT_GAMECONTROLLER) == 0);
    index = SDL_JoystickAttachVirtual(SDL_JOYSTICK_TYPE_GAMECONTROLLER, SDL_CONTROLLER_AXIS_MAX,
                                      SDL_CONTROLLER_BUTTON_MAX, 0);
    REQUIRE(index >= 0);
    joystick = SDL_JoystickOpen(index);
    REQUIRE(joystick);
  }
  ~VirtualGamepad() {
    SDL_JoystickClose(joystick);
    if (index >= 0) SDL_JoystickDetachVirtual(index);
    SDL_QuitSubSystem(SDL_INIT_GAMECONTROLLER);
  }

  void push(SDL_GameControllerAxis axis, double share) const {
    SDL_JoystickSetVirtualAxis(joystick, axis, static_cast<Sint16>(32767 * share));
  }
  void press(SDL_GameControllerButton button, bool down) const {
    SDL_JoystickSetVirtualButton(joystick, button, down ? 1 : 0);
  }

  int index = -1;
  SDL_Joystick* joystick = nullptr;
};

}  // namespace

TEST_CASE("a gamepad's left stick pushes the needle in, its lower button is the clutch") {
  VirtualGamepad hardware;
  double now = 0;
  Gamepad gamepad(250, [&] { return now; });
  const DeviceProperties properties = gamepad.open();
  CHECK(properties.rate == 250);
  CHECK(properties.translation.largest_force == 0);
  gamepad.read();
  hardware.push(SDL_CONTROLLER_AXIS_LEFTY, -1);  // forward
  gamepad.read();
  Device::Reading reading;
  for (int i = 0; i < 50; ++i) {
    now += 0.01;
    reading = gamepad.read();
  }
  CHECK(reading.pose.position[0] == doctest::Approx(0.5 * 0.03).epsilon(1e-3));
  CHECK_FALSE(reading.clutch);
  hardware.press(SDL_CONTROLLER_BUTTON_A, true);
  gamepad.read();
  CHECK(gamepad.read().clutch);
  gamepad.write({{{1, 0, 0}}, {}});  // does nothing, harms nothing
  gamepad.close();
  gamepad.close();
}

TEST_CASE("a gamepad that is pulled out is an error") {
  VirtualGamepad hardware;
  Gamepad gamepad(250, [] { return 0.0; });
  gamepad.open();
  SDL_JoystickDetachVirtual(hardware.index);
  hardware.index = -1;
  CHECK_THROWS_AS(gamepad.read(), DeviceError);
}
