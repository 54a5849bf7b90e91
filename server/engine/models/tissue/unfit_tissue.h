// SPDX-License-Identifier: GPL-3.0-or-later
// A tissue that cannot be computed as its scene asks for.
#pragma once

#include <stdexcept>
#include <string>

namespace acus {

struct UnfitTissue : std::runtime_error {
  UnfitTissue(const char* scene_field, const std::string& what) : std::runtime_error(what), field(scene_field) {}

  const char* field;  // of the scene, that could be otherwise: "tissue.window"
};

}  // namespace acus
