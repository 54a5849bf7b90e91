// SPDX-License-Identifier: GPL-3.0-or-later
// A recording that a server starts with: its ticks are made again up to a moment, and the simulation continues from
// there as after a restored snapshot. No command waits, and bases rest where they were going.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "server/runtime/loaded_scene.h"

namespace acus {

struct RecordedStart {
  std::string recording;     // file
  std::optional<double> at;  // s of simulation time from the recording's beginning; unless told, its end
};

// The scene that the recording is in at that moment, in the state of that moment: that after the nearest tick. Tells
// the log how far it is. Null if interrupted(), which is asked before each tick. Throws RecordingError, SceneError.
std::unique_ptr<LoadedScene> load_recorded(const RecordedStart& start, const std::function<bool()>& interrupted);

}  // namespace acus
