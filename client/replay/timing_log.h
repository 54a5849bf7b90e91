// SPDX-License-Identifier: MIT
// The timing of a run in real time as CSV: RUN.csv with a row per pose that a state used, RUN.stats.csv with a row per
// `stats` message. Times are seconds since the start of the run, durations are seconds.
#pragma once

#include <fstream>
#include <string>
#include <vector>

#include "client/replay/log_file.h"
#include "client/replay/run_statistics.h"
#include "protocol/messages.h"

namespace acus::client {

class TimingLog {
 public:
  // Of two files. Throws LogError if one cannot be written.
  explicit TimingLog(const std::string& path);

  void write(const protocol::Stats& stats, double received_s);
  void write(const std::vector<RoundTrip>& trips);

  // Everything is on its way to the disk after this. Throws LogError if anything could not be written.
  void close();

  // Where the statistics of a timing go that is written to `path`.
  static std::string stats_path_beside(const std::string& path);

  bool begun() const { return trips_.begun() || stats_.begun(); }  // whether there was anything to write
  const std::string& path() const { return trips_.path(); }
  const std::string& stats_path() const { return stats_.path(); }

 private:
  LogFile trips_;
  LogFile stats_;
};

}  // namespace acus::client
