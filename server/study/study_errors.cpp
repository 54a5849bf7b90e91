// SPDX-License-Identifier: GPL-3.0-or-later
#include <stdexcept>
#include <utility>

#include "server/simulation/scene_fields.h"
#include "server/study/csv.h"
#include "server/study/error_settings.h"
#include "server/study/errors.h"
#include "server/study/study.h"

namespace acus {

namespace {

const std::vector<std::string> kColumns{"scene",
                                        "knob",
                                        "setting",
                                        "error",  // what was run, compared with what
                                        "h",
                                        "rung",
                                        "iterations",
                                        "solver",
                                        "tolerance",
                                        "max_sweeps",  // s, ..., N
                                        "nodes",
                                        "beams",
                                        "spacing",  // m
                                        "tip_max",
                                        "tip_rms",
                                        "tip_p95",  // m: errors
                                        "force_max",
                                        "force_rms",
                                        "force_p95",  // N
                                        "tissue_max",
                                        "tissue_rms",
                                        "tissue_p95",  // m
                                        "tip_size",
                                        "force_size",
                                        "tissue_size",  // m, N, m: largest of the reference
                                        "run_time",
                                        "ms_per_tick",  // processor s per simulated s, ms
                                        "mean_iterations",
                                        "mean_sweeps",
                                        "residual",
                                        "flagged",
                                        "ticks"};  // per tick, N

struct Run {
  Scene scene;
  int nodes;
  Recording recording;
};

std::vector<Cell> cells(const Setting& setting, const Run& run, const Comparison& comparison,
                        const Recording& reference) {
  const Scene& s = run.scene;
  const Recording& r = run.recording;
  const Errors e = errors(r, reference), size = magnitudes(reference);
  const double ticks = static_cast<double>(r.ticks);
  return {setting.knob,
          setting.value,
          comparison.kind,
          setting.h,
          name_of(s.tissue.rung),
          s.newton.max_iterations,
          name_of(s.laws.solver),
          s.laws.tolerance,
          s.laws.max_sweeps,
          run.nodes,
          s.needles[0].beams,
          s.needles[0].constraint_spacing,
          e.tip.max,
          e.tip.rms,
          e.tip.p95,
          e.force.max,
          e.force.rms,
          e.force.p95,
          e.tissue.max,
          e.tissue.rms,
          e.tissue.p95,
          size.tip.max,
          size.force.max,
          size.tissue.max,
          r.processor_seconds / (ticks * setting.h),
          1e3 * r.processor_seconds / ticks,
          r.iterations,
          r.sweeps,
          r.residual,
          r.flagged,
          r.ticks};
}

// All runs of one scene and their rows in its table.
class SceneStudy {
 public:
  SceneStudy(const StudiedScene& studied, const StudyPlan& plan)
      : name_(studied.name),
        plan_(plan),
        experiment_(read_experiment(plan.scenes, studied.name, studied.pace)),
        probes_(nodes_of(experiment_)),
        settings_(settings_of(studied)),
        table_(plan.out + "/errors_" + name_ + ".csv", kColumns) {}

  void run() {
    const int count = static_cast<int>(settings_.size());
    for (const Setting& setting : settings_) {
      plan_.progress(
          static_cast<int>(runs_.size()), count,
          name_ + ", " + setting.knob + " " + setting.value + ", tick of " + format_number(1e3 * setting.h) + " ms");
      runs_.push_back(make(setting));
      for (const Comparison& comparison : setting.comparisons) write(setting, comparison);
    }
    plan_.progress(count, count, name_ + " done");
  }

 private:
  Run make(const Setting& setting) const {
    Experiment experiment = experiment_;
    experiment.scene.rate = 1 / setting.h;
    setting.change(experiment.scene);
    const int nodes = static_cast<int>(nodes_of(experiment).cols());
    return {experiment.scene, nodes, record(experiment, probes_)};
  }

  void write(const Setting& setting, const Comparison& comparison) {
    std::vector<Cell> row{name_};
    for (Cell& cell : cells(setting, runs_.back(), comparison, runs_[comparison.with].recording))
      row.push_back(std::move(cell));
    table_.row(row);
  }

  std::string name_;
  const StudyPlan& plan_;
  Experiment experiment_;
  Matrix3X probes_;
  std::vector<Setting> settings_;
  CsvFile table_;
  std::vector<Run> runs_;  // per setting so far
};

}  // namespace

void study_errors(const StudyPlan& plan) {
  std::string names;
  bool any = false;
  for (const StudiedScene& studied : studied_scenes(plan.quick)) {
    names += (names.empty() ? "" : ", ") + std::string(studied.name);
    if (!plan.scene.empty() && plan.scene != studied.name) continue;
    SceneStudy(studied, plan).run();
    any = true;
  }
  if (!any) throw std::runtime_error("--scene: expected one of " + names + ", found '" + plan.scene + "'");
}

}  // namespace acus
