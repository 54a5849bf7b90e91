// SPDX-License-Identifier: MIT
#include "client/replay/run_summary.h"

#include <nlohmann/json.hpp>

#include "protocol/own_file.h"

namespace acus::client {

namespace {

using Json = nlohmann::ordered_json;

Json needles_of(const RunStatistics& statistics) {
  Json needles = Json::array();
  for (const auto& [name, run] : statistics.needles()) {
    needles.push_back({{"name", name},
                       {"states", run.states},
                       {"lost", run.lost},
                       {"deepest_m", run.extremes.depth},
                       {"peak_push_N", run.extremes.push},
                       {"peak_pull_N", run.extremes.pull},
                       {"peak_lateral_N", run.extremes.lateral},
                       {"peak_torque_Nm", run.extremes.torque}});
  }
  return needles;
}

Json flags_of(const RunStatistics& statistics) {
  Json flags = Json::object();
  const auto& flagged = statistics.flagged();
  for (std::size_t bit = 0; bit < flagged.size(); ++bit)
    if (flagged[bit] > 0) flags[protocol::kFlagNames[bit]] = flagged[bit];
  return flags;
}

Json timing_of(const Punctuality& server, const MeasuredTiming& measured) {
  return {{"ticks", server.ticks},
          {"late_ticks", server.late},
          {"late_per_1000", measured.late_per_1000},
          {"tick_began_max_ms", 1e3 * server.wake_max},
          {"tick_ended_p50_ms", 1e3 * server.end_p50},
          {"tick_ended_max_ms", 1e3 * server.end_max},
          {"round_trip_p50_ms", 1e3 * measured.times.p50},
          {"round_trip_p99_ms", 1e3 * measured.times.p99},
          {"round_trip_max_ms", 1e3 * measured.times.max}};
}

Json limits_of(const std::vector<TimingLimit>& limits) {
  Json list = Json::array();
  for (const TimingLimit& limit : limits)
    list.push_back(
        {{"option", limit.option}, {"most", limit.most}, {"measured", limit.measured}, {"held", limit.held()}});
  return list;
}

}  // namespace

MeasuredTiming measured_timing(const Replay& replay) {
  const Punctuality& server = replay.statistics().punctuality();
  std::vector<double> times;
  for (const RoundTrip& trip : replay.round_trips()) times.push_back(trip.seconds);
  const double ticks = static_cast<double>(server.ticks);
  return {ticks > 0 ? 1e3 * static_cast<double>(server.late) / ticks : 0, distribution_of(std::move(times))};
}

std::string run_summary(const Replay& replay, const ReplayOptions& options, const MeasuredTiming& measured,
                        const std::vector<TimingLimit>& limits) {
  const RunStatistics& statistics = replay.statistics();
  Json json{{protocol::kWrittenBy, protocol::kWriter},
            {"scene", replay.server().scene},
            {"lockstep", options.lockstep},
            {"rate_Hz", replay.server().rate},
            {"rate_held_Hz", statistics.rate()},
            {"overruns", statistics.overruns()},
            {"poses_sent", replay.poses_sent()},
            {"deadlines_missed", replay.deadlines_missed()},
            {"messages_rejected", statistics.rejections()},
            {"states", statistics.states()},
            {"states_lost", statistics.lost()},
            {"events", statistics.events()},
            {"flags", flags_of(statistics)},
            {"needles", needles_of(statistics)}};
  if (!options.lockstep) {
    json["timing"] = timing_of(statistics.punctuality(), measured);
    json["limits"] = limits_of(limits);
  }
  return json.dump(2) + "\n";
}

}  // namespace acus::client
