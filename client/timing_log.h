// SPDX-License-Identifier: MIT
// The timing of a run in real time as CSV: RUN.csv with a row per pose that a state used, RUN.stats.csv with a row per
// `stats` message. Times are seconds since the start of the run, durations are seconds.
#pragma once

#include <fstream>
#include <string>
#include <vector>

#include "client/log_file.h"
#include "client/run_statistics.h"
#include "protocol/messages.h"

namespace acus::client {

class TimingLog {
 public:
  // Creates both files with their headers. Throws LogError.
  explicit TimingLog(const std::string& path);

  void write(const protocol::Stats& stats, double received_s);
  void write(const std::vector<RoundTrip>& trips);

  // Everything is on its way to the disk after this. Throws LogError if anything could not be written.
  void close();

  // Where the statistics of a timing go that is written to `path`.
  static std::string stats_path_beside(const std::string& path);

  const std::string& path() const { return path_; }
  const std::string& stats_path() const { return stats_path_; }

 private:
  std::string path_;
  std::string stats_path_;
  std::ofstream trips_;
  std::ofstream stats_;
};

}  // namespace acus::client
