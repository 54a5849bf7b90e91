// SPDX-License-Identifier: MIT
#include "client/haptics/devices/gamepad.h"

#include <SDL.h>

#include <string>
#include <utility>

#include "client/haptics/devices/rate_control.h"

namespace acus::haptics {

struct Gamepad::Hardware {
  SDL_GameController* controller = nullptr;
  RateControl control;
};

namespace {

// The first joystick that SDL knows the buttons of, null if there is none.
SDL_GameController* first_controller() {
  for (int i = 0; i < SDL_NumJoysticks(); ++i)
    if (SDL_IsGameController(i))
      if (SDL_GameController* controller = SDL_GameControllerOpen(i)) return controller;
  return nullptr;
}

}  // namespace

Gamepad::Gamepad(double rate, std::function<double()> clock) : rate_(rate), clock_(std::move(clock)) {}

Gamepad::~Gamepad() { close(); }

DeviceProperties Gamepad::open() {
  SDL_SetHint(SDL_HINT_JOYSTICK_ALLOW_BACKGROUND_EVENTS, "1");  // there is no window that could have the focus
  SDL_SetHint(SDL_HINT_NO_SIGNAL_HANDLERS, "1");
  if (SDL_InitSubSystem(SDL_INIT_GAMECONTROLLER) != 0)
    throw DeviceError(std::string("gamepad: SDL: ") + SDL_GetError());
  hardware_ = std::make_unique<Hardware>();
  hardware_->controller = first_controller();
  if (!hardware_->controller) {
    close();
    throw DeviceError("gamepad: none is connected that SDL knows");
  }
  return without_force(rate_);
}

Device::Reading Gamepad::read() {
  SDL_GameControllerUpdate();
  if (!SDL_GameControllerGetAttached(hardware_->controller)) throw DeviceError("gamepad: it was disconnected");
  const auto axis = [this](SDL_GameControllerAxis which) {
    return SDL_GameControllerGetAxis(hardware_->controller, which) / 32767.0;
  };
  Deflection deflection;
  deflection.translation = {
      {-axis(SDL_CONTROLLER_AXIS_LEFTY), -axis(SDL_CONTROLLER_AXIS_LEFTX), -axis(SDL_CONTROLLER_AXIS_RIGHTY)}};
  deflection.rotation = {{0, 0, -axis(SDL_CONTROLLER_AXIS_RIGHTX)}};
  const bool clutch = SDL_GameControllerGetButton(hardware_->controller, SDL_CONTROLLER_BUTTON_A) != 0;
  return {hardware_->control.step(deflection, clock_()), clutch};
}

void Gamepad::close() {
  if (!hardware_) return;
  if (hardware_->controller) SDL_GameControllerClose(hardware_->controller);
  hardware_.reset();
  SDL_QuitSubSystem(SDL_INIT_GAMECONTROLLER);
}

}  // namespace acus::haptics
