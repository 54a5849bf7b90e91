// SPDX-License-Identifier: MIT
#include "client/replay/timing_log.h"

#include <filesystem>
#include <iomanip>

namespace acus::client {
namespace {

constexpr int kDigits = 9;  // of a number: nanoseconds within a second, microseconds within a quarter of an hour

}  // namespace

TimingLog::TimingLog(const std::string& path)
    : trips_(path, "seq,sent_s,round_trip_s\n"),
      stats_(stats_path_beside(path),
             "received_s,period_s,time_step_s,ticks,late,overruns,tick_p50_s,tick_p99_s,tick_max_s,"
             "wake_p50_s,wake_p99_s,wake_max_s,end_p50_s,end_p99_s,end_max_s,flags\n") {}

std::string TimingLog::stats_path_beside(const std::string& path) {
  return std::filesystem::path(path).replace_extension(".stats.csv").string();
}

void TimingLog::write(const protocol::Stats& stats, double received_s) {
  const double time_step = stats.tick > 0 ? stats.time / static_cast<double>(stats.tick) : 0;
  std::ofstream& out = stats_.out();
  out << std::setprecision(kDigits) << received_s << ',' << stats.period << ',' << time_step << ',' << stats.ticks
      << ',' << stats.late << ',' << stats.overruns;
  for (const double seconds : {stats.tick_p50, stats.tick_p99, stats.tick_max, stats.wake_p50, stats.wake_p99,
                               stats.wake_max, stats.end_p50, stats.end_p99, stats.end_max}) {
    out << ',' << seconds;
  }
  out << ',' << stats.flags << '\n';
}

void TimingLog::write(const std::vector<RoundTrip>& trips) {
  stats_.out();  // a run shorter than a period of the statistics leaves their header
  std::ofstream& out = trips_.out();
  out << std::setprecision(kDigits);
  for (const RoundTrip& trip : trips) out << trip.seq << ',' << trip.sent << ',' << trip.seconds << '\n';
}

void TimingLog::close() {
  trips_.close();
  stats_.close();
}

}  // namespace acus::client
