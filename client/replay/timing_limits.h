// SPDX-License-Identifier: MIT
// Limits on the timing of a run, from the command line, so that a script can tell by the exit status whether a rate is
// held.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdio>
#include <optional>
#include <string>
#include <vector>

#include "client/replay/latency.h"

namespace acus::client {

struct TimingLimits {
  std::optional<double> late_per_1000, p50_ms, p99_ms, max_ms;
};

struct MeasuredTiming {
  double late_per_1000 = 0;  // ticks that ended after the next one was due
  Distribution times;        // s
};

struct TimingLimit {
  std::string option;
  double most = 0, measured = 0;

  bool held() const { return measured <= most; }
};

// Adds the options as a group, which is returned. `times` says what the limits in milliseconds are about, "a tick".
inline CLI::Option_group& declare(CLI::App& app, TimingLimits& limits, const std::string& times) {
  CLI::Option_group& group = *app.add_option_group("Limits", "The exit status tells whether they were held");
  const auto add = [&group](const char* name, std::optional<double>& value, const std::string& meaning) {
    group.add_option(name, value, meaning)->check([](const std::string& text) {
      double number = 0;
      const bool good = CLI::detail::lexical_cast(text, number) && number >= 0;  // NaN is not
      return good ? std::string() : "expected a number of at least 0, found '" + text + "'";
    });
  };
  add("--max-late-per-1000", limits.late_per_1000, "Most late ticks in a thousand");
  add("--max-p50-ms", limits.p50_ms, "Longest that " + times + " may take at the median");
  add("--max-p99-ms", limits.p99_ms, "Longest that 99 of 100 may take");
  add("--max-ms", limits.max_ms, "Longest that any may take");
  return group;
}

// Those that were given.
inline std::vector<TimingLimit> compare(const TimingLimits& limits, const MeasuredTiming& measured) {
  std::vector<TimingLimit> compared;
  const auto add = [&](const char* option, const std::optional<double>& most, double value) {
    if (most) compared.push_back({option, *most, value});
  };
  add("--max-late-per-1000", limits.late_per_1000, measured.late_per_1000);
  add("--max-p50-ms", limits.p50_ms, 1e3 * measured.times.p50);
  add("--max-p99-ms", limits.p99_ms, 1e3 * measured.times.p99);
  add("--max-ms", limits.max_ms, 1e3 * measured.times.max);
  return compared;
}

// Tells each on standard error that was exceeded; true if none was.
inline bool all_held(const char* program, const std::vector<TimingLimit>& limits) {
  bool held = true;
  for (const TimingLimit& limit : limits) {
    if (limit.held()) continue;
    held = false;
    std::fprintf(stderr, "%s: %s %g was exceeded: %g\n", program, limit.option.c_str(), limit.most, limit.measured);
  }
  return held;
}

}  // namespace acus::client
