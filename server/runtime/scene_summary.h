// SPDX-License-Identifier: GPL-3.0-or-later
// What a scene that could be loaded contains, what it will cost and what it leaves out, in words and aligned columns
// for a person to read.
#pragma once

#include <string>

#include "server/engine/tick/simulation.h"

namespace acus {

std::string summarise(const Simulation& simulation);

}  // namespace acus
