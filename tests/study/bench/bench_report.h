// SPDX-License-Identifier: GPL-3.0-or-later
// What acus-bench tells about a run, as a table for eyes and as JSON for programs.
#pragma once

#include <string>

#include "tests/study/bench/history.h"
#include "tests/study/bench/measurement.h"

namespace acus {

struct BenchRun {
  std::string scene_file, trajectory_file;
  int core = 0;             // that the program is pinned to
  double load_seconds = 0;  // from the scene file to the first tick
  double peak_memory = 0;   // bytes, resident, up to the end of loading; the calibration is not in it
  Measurement measured;
};

std::string bench_table(const BenchRun& run, const Simulation& simulation, const Calibration& calibration);
// What stays to be compared with; without date, commit and change.
HistoryRow history_row(const BenchRun& run, const Simulation& simulation);

std::string bench_json(const BenchRun& run, const Simulation& simulation, const Calibration& calibration);

}  // namespace acus
