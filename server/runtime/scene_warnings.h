// SPDX-License-Identifier: GPL-3.0-or-later
// What is probably a mistake in a scene that can be used, each with its remedy: lengths in millimetres, needles that stand
// in tissue or point away from it, quaternions in another order, materials that are none, tips that crush elements.
#pragma once

#include <string>
#include <vector>

#include "server/engine/tick/simulation.h"

namespace acus {

struct SceneWarning {
  std::string of;    // region, needle or "tissue"
  std::string text;  // what is found, then a remedy
};

std::vector<SceneWarning> scene_warnings(const Simulation& simulation);

}  // namespace acus
