// SPDX-License-Identifier: GPL-3.0-or-later
#include <stdexcept>
#include <utility>

#include "server/engine/scene/scene_fields.h"
#include "tests/study/studies/csv.h"
#include "tests/study/studies/error_settings.h"
#include "tests/study/studies/errors.h"
#include "tests/study/studies/study.h"

namespace acus {

namespace {

struct Run {
  Scene scene;
  int nodes;
  Recording recording;
};

// What a row tells of: a run and what it is compared with.
struct Compared {
  const std::string& scene;
  const Setting& setting;
  const char* kind;
  const Run& run;
  Errors error, size;
};

constexpr Column<Compared> kColumns[]{
    {"scene", [](const Compared& c) { return Cell(c.scene); }},
    {"knob", [](const Compared& c) { return Cell(c.setting.knob); }},
    {"setting", [](const Compared& c) { return Cell(c.setting.value); }},
    {"error", [](const Compared& c) { return Cell(c.kind); }},
    {"h", [](const Compared& c) { return Cell(c.setting.h); }},  // s
    {"rung", [](const Compared& c) { return Cell(name_of(c.run.scene.tissue.rung)); }},
    {"iterations", [](const Compared& c) { return Cell(c.run.scene.newton.max_iterations); }},
    {"solver", [](const Compared& c) { return Cell(acus::name_of(c.run.scene.laws.solver)); }},
    {"tolerance", [](const Compared& c) { return Cell(c.run.scene.laws.tolerance); }},  // N
    {"max_steps", [](const Compared& c) { return Cell(c.run.scene.laws.max_steps); }},
    {"nodes", [](const Compared& c) { return Cell(c.run.nodes); }},
    {"beams", [](const Compared& c) { return Cell(c.run.scene.needles[0].beams); }},
    {"spacing", [](const Compared& c) { return Cell(c.run.scene.needles[0].constraint_spacing); }},  // m
    {"tip_max", [](const Compared& c) { return Cell(c.error.tip.max); }},                            // m
    {"tip_rms", [](const Compared& c) { return Cell(c.error.tip.rms); }},
    {"tip_p95", [](const Compared& c) { return Cell(c.error.tip.p95); }},
    {"force_max", [](const Compared& c) { return Cell(c.error.force.max); }},  // N
    {"force_rms", [](const Compared& c) { return Cell(c.error.force.rms); }},
    {"force_p95", [](const Compared& c) { return Cell(c.error.force.p95); }},
    {"tissue_max", [](const Compared& c) { return Cell(c.error.tissue.max); }},  // m
    {"tissue_rms", [](const Compared& c) { return Cell(c.error.tissue.rms); }},
    {"tissue_p95", [](const Compared& c) { return Cell(c.error.tissue.p95); }},
    {"tip_size", [](const Compared& c) { return Cell(c.size.tip.max); }},  // m, N, m: largest of the reference
    {"force_size", [](const Compared& c) { return Cell(c.size.force.max); }},
    {"tissue_size", [](const Compared& c) { return Cell(c.size.tissue.max); }},
    {"run_time", [](const Compared& c) { return Cell(c.run.recording.run_time()); }},  // s per simulated s
    {"ms_per_tick", [](const Compared& c) { return Cell(1e3 * c.run.recording.run_time() * c.setting.h); }},
    {"calibrated", [](const Compared& c) { return Cell(c.run.recording.calibrated()); }},  // - per tick
    {"mean_iterations", [](const Compared& c) { return Cell(c.run.recording.iterations); }},
    {"mean_sweeps", [](const Compared& c) { return Cell(c.run.recording.sweeps); }},
    {"residual", [](const Compared& c) { return Cell(c.run.recording.residual); }},            // N
    {"not_converged", [](const Compared& c) { return Cell(c.run.recording.not_converged); }},  // ticks
    {"ticks", [](const Compared& c) { return Cell(c.run.recording.ticks); }},
};

// All runs of one scene and their rows in its table.
class SceneStudy {
 public:
  SceneStudy(const StudiedScene& studied, const StudyPlan& plan)
      : name_(studied.name),
        plan_(plan),
        experiment_(read_experiment(plan.scenes, studied.name, studied.pace)),
        probes_(nodes_of(experiment_)),
        settings_(settings_of(studied)),
        table_(plan.out + "/errors_" + name_ + ".csv", names_of(kColumns)) {}

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
    const Recording& reference = runs_[comparison.with].recording;
    const Run& run = runs_.back();
    const Compared compared{
        name_, setting, comparison.kind, run, errors(run.recording, reference), magnitudes(reference)};
    table_.row(cells_of(kColumns, compared));
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
