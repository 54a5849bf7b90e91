// SPDX-License-Identifier: GPL-3.0-or-later
// What a scene that could be loaded contains, what it will cost and what it leaves out, in words and aligned columns
// for a person to read.
#pragma once

#include <string>
#include <vector>

#include "server/engine/tick/simulation.h"
#include "server/runtime/scene_warnings.h"

namespace acus {

// With the scene's warnings, and `more` of them that are known from elsewhere.
std::string summarise(const Simulation& simulation, const std::vector<SceneWarning>& more = {});

}  // namespace acus
