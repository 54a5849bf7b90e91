// SPDX-License-Identifier: MIT
#include "client/haptics/program/haptic_summary.h"

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <vector>

#include "client/replay/run_statistics.h"
#include "protocol/own_file.h"

namespace acus::haptics {

namespace {

// N/m that this share of what was felt is below; 0 if nothing was.
double felt_share(const SessionResults& results, double share) {
  if (results.felt.empty()) return 0;
  std::vector<double> felt = results.felt;
  std::sort(felt.begin(), felt.end());
  return client::percentile(felt, share);
}

}  // namespace

std::string readable(const SessionResults& results, const std::string& device) {
  const client::Distribution delay = client::distribution_of(results.delays);
  char felt[64] = "nothing was felt over a way of 0.2 mm";
  if (!results.felt.empty())
    std::snprintf(felt, sizeof felt, "median %.0f N/m, a tenth of it above %.0f N/m", felt_share(results, 0.5),
                  felt_share(results, 0.9));
  char rest[80] = "no rest with a force";
  if (const auto& worst = results.rest.worst())
    std::snprintf(rest, sizeof rest, "%.3f N felt%s, %.3f N of the server", worst->felt,
                  results.shared ? " by both hands" : "", worst->server);
  char text[1500];
  std::snprintf(
      text, sizeof text,
      "device      %s on %s of %s\n"
      "rate        %.1f Hz, %llu samples in %.2f s%s, %llu late%s\n"
      "delay       p50 %.2f ms, p99 %.2f ms, max %.2f ms, from a command to the first state that used it\n"
      "states      %llu of the topic %s; %llu samples without a fresh one\n"
      "force       %.3f N at most; at rest: %s\n"
      "stiffness   felt: %s; the coupling allows %.0f N/m\n"
      "energy      %.6f J kept from the hand by the controller; the force did %.6f J of work on the handle, net\n",
      device.c_str(), results.needle.c_str(), results.scene.c_str(), results.rate,
      static_cast<unsigned long long>(results.samples), results.duration, results.lockstep ? " of simulation" : "",
      static_cast<unsigned long long>(results.late), results.punctual ? "" : " (no real-time priority here)",
      1e3 * delay.p50, 1e3 * delay.p99, 1e3 * delay.max, static_cast<unsigned long long>(results.models),
      results.topic.c_str(), static_cast<unsigned long long>(results.stale), results.largest_force, rest, felt,
      results.coupling.translation, results.withheld, results.given);
  return text;
}

std::string as_json(const SessionResults& results, const std::string& device) {
  const client::Distribution delay = client::distribution_of(results.delays);
  const nlohmann::ordered_json json{
      {acus::protocol::kWrittenBy, acus::protocol::kWriter},
      {"device", device},
      {"scene", results.scene},
      {"needle", results.needle},
      {"topic", results.topic},
      {"kit", results.with_kit},
      {"shared", results.shared},
      {"lockstep", results.lockstep},
      {"duration_s", results.duration},
      {"samples", results.samples},
      {"rate_Hz", results.rate},
      {"late_samples", results.late},
      {"realtime_priority", results.punctual},
      {"states", results.models},
      {"stale_samples", results.stale},
      {"delay_p50_s", delay.p50},
      {"delay_p99_s", delay.p99},
      {"delay_max_s", delay.max},
      {"largest_force_N", results.largest_force},
      {"coupling_N_per_m", results.coupling.translation},
      {"felt_median_N_per_m", felt_share(results, 0.5)},
      {"felt_p90_N_per_m", felt_share(results, 0.9)},
      {"rest_felt_N", results.rest.worst() ? nlohmann::ordered_json(results.rest.worst()->felt) : nullptr},
      {"rest_server_N", results.rest.worst() ? nlohmann::ordered_json(results.rest.worst()->server) : nullptr},
      {"withheld_J", results.withheld},
      {"given_J", results.given},
  };
  return json.dump(2) + "\n";
}

}  // namespace acus::haptics
