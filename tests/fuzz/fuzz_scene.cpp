// SPDX-License-Identifier: GPL-3.0-or-later
// Scenes: a text is a scene whose values are in range, or refused with a place in it.
#include <string>

#include "server/engine/scene/scene.h"
#include "tests/fuzz/fuzz.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    const acus::Scene scene = acus::parse_scene(std::string(acus::fuzz::text_of(data, size)), "scene.yaml");
    acus::validate(scene);
  } catch (const acus::SceneError& error) {
    acus::fuzz::require(std::string_view(error.what()).starts_with("scene.yaml"), "an error names the scene");
  }
  return 0;
}
