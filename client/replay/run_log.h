// SPDX-License-Identifier: MIT
// A run as CSV: RUN.csv with a row per received force state, RUN.events.csv with a row per event. The columns are the
// fields of protocol::Force and protocol::Event, in their order; vectors and quaternions take a column per component
// and the unit ends the name: base_force_x_N, base_orientation_w, depth_m. Numbers are written so that they read back
// exactly, so a lockstep run gives the same bytes each time.
#pragma once

#include <fstream>
#include <string>

#include "client/replay/log_file.h"
#include "protocol/messages.h"

namespace acus::client {

class RunLog {
 public:
  // Of two files; throws LogError if one cannot be written. With `wall_time`, force rows end with received_s: seconds
  // of wall time from the start of the run to the arrival of the state.
  RunLog(const std::string& path, bool wall_time);

  void write(const protocol::Force& force, double received_s);
  void write(const protocol::Event& event);

  // Everything is on its way to the disk after this. Throws LogError if anything could not be written.
  void close();

  // Where the events of a run go that is written to `path`.
  static std::string events_path_beside(const std::string& path);

  bool begun() const { return forces_.begun(); }  // whether there was anything to write
  const std::string& path() const { return forces_.path(); }
  const std::string& events_path() const { return events_.path(); }

 private:
  bool wall_time_;
  LogFile forces_;
  LogFile events_;
  std::string row_;  // being built
};

}  // namespace acus::client
