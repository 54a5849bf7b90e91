// SPDX-License-Identifier: GPL-3.0-or-later
// Ratios of earlier measurements, in a CSV file with the columns of kHistoryColumns, and whether a new one is worse.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace acus {

inline constexpr const char* kHistoryColumns =
    "date,commit,processor,kernels,scene,tick_p50_to_calibration,tick_p99_to_p50,state_hash,change";

struct HistoryRow {
  std::string date, commit;
  std::string processor;                      // processor_name()
  std::string kernels;                        // name_of(KernelSet)
  std::string scene;                          // file name without folder and ending
  double to_calibration = 0, p99_to_p50 = 0;  // of processor times
  std::string state_hash, change;
};

// Model, family and number of this machine's processor, without commas.
std::string processor_name();

// Throws std::runtime_error, with file and line, where the file cannot be read or a row is none.
std::vector<HistoryRow> read_history(const std::string& path);

// The last row of the same processor, kernels and scene.
std::optional<HistoryRow> last_comparable(const std::vector<HistoryRow>& history, const HistoryRow& now);

struct RatioComparison {
  static constexpr double kMostWorse = 0.1;

  const char* name;
  double before, now;

  double worse() const { return now / before - 1; }
  bool held() const { return worse() <= kMostWorse; }  // false for what is not a number
};
std::vector<RatioComparison> compare(const HistoryRow& before, const HistoryRow& now);

}  // namespace acus
