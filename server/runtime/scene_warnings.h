// SPDX-License-Identifier: GPL-3.0-or-later
// What is probably a mistake in a scene that can be used, each with its remedy: values in another unit
// (unusual_values.h), regions in pieces (region_resolution.h), tissue that nothing holds, needles that stand in tissue,
// far from it or point away from it, quaternions in another order, tips that crush elements.
#pragma once

#include "server/engine/tick/simulation.h"
#include "server/runtime/scene_warning.h"

namespace acus {

SceneWarnings scene_warnings(const Simulation& simulation);

}  // namespace acus
