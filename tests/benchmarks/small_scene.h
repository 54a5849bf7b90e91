// SPDX-License-Identifier: GPL-3.0-or-later
// A block of 4 x 4 x 4 nodes with a needle 2 mm above it, and a motion 10 mm into it.
#pragma once

#include "client/replay/trajectory.h"
#include "server/engine/scene/scene.h"

namespace acus::test {

Scene small_scene();              // 1000 Hz
client::Trajectory small_push();  // from t = 2 s, 0.125 s long
}  // namespace acus::test
