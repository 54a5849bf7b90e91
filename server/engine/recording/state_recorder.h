// SPDX-License-Identifier: GPL-3.0-or-later
// Writes down a state that its owner steps, in the thread that steps it: recordings of programs without a server.
#pragma once

#include <memory>
#include <string>

#include "server/engine/recording/recording_file.h"
#include "server/engine/state/report.h"
#include "server/engine/state/state.h"

namespace acus {

class StateRecorder {
 public:
  // Creates the file, which must not be there, and begins with this state. `version` is that of Acus.
  // Throws RecordingError.
  StateRecorder(const std::string& path, const std::string& version, std::shared_ptr<const recorded::World> world,
                const State& state);
  ~StateRecorder();  // ends it, if it can
  StateRecorder(const StateRecorder&) = delete;
  StateRecorder& operator=(const StateRecorder&) = delete;

  // For the next tick.
  void command(int body, const Command& command) { writer_.add(recorded::BodyCommand{body, command}); }
  // Was made; `economizing` before it. Writes twice a second of simulation time. Throws RecordingError, and the
  // recording ends before what could not be written.
  void tick(bool economizing, const TickReport& report, const State& after);
  // Writes the rest, and that it ends here. Throws RecordingError.
  void end();

 private:
  void flush();

  RecordingWriter writer_;
  const std::shared_ptr<const recorded::World> world_;
  const std::uint64_t half_second_;  // ticks
  Hasher hasher_;
  bool ended_ = false;  // or could not be written on
};

}  // namespace acus
