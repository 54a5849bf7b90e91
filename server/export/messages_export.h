// SPDX-License-Identifier: GPL-3.0-or-later
// A run as the messages that the server would have sent a viewer, for one to show: protocol/README.md, "Recorded
// messages".
#pragma once

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "server/export/frame_clock.h"
#include "server/export/message_file.h"
#include "server/export/recorded_states.h"

namespace acus {

class MessagesExport {
 public:
  // Of the scene that the rerun is in, with `rate` frames a second of simulation time (Hz). Throws client::LogError,
  // here and below.
  MessagesExport(const std::string& path, double rate, const Rerun& rerun);

  // After a tick: takes in its forces and events, and writes a frame if one is due. Those of other scenes, to which the
  // recording goes over by `load`, have no place in the file and are left out.
  void take(const Rerun& rerun);

  // A last frame after the last tick, and the end of the file.
  void close(const Rerun& rerun);

 private:
  // A state of a needle, and the tick of the rerun that it is of.
  struct Kept {
    std::uint64_t tick = 0;
    double force = 0;  // N, at the base
    protocol::Force message;
  };
  // Of a needle in the ticks since the last frame.
  struct Forces {
    std::optional<Kept> smallest, largest, last;
  };
  // Tick of the rerun, and place among what is told of it.
  using Place = std::pair<std::uint64_t, std::size_t>;

  void keep_forces(const Rerun& rerun);
  void keep_events(const Rerun& rerun);
  void write_frame(const Rerun& rerun);
  void write_kept();

  MessageFile file_;
  FrameClock clock_;
  const int world_;
  RecordedShapes shapes_;
  std::vector<Forces> forces_;         // of the needles
  std::map<Place, std::string> kept_;  // encoded, for the next frame: events as they come, forces when it is due
};

}  // namespace acus
