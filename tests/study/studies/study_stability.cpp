// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>

#include "tests/study/studies/csv.h"
#include "tests/study/studies/stability_cases.h"
#include "tests/study/studies/stability_run.h"
#include "tests/study/studies/study.h"

namespace acus {

namespace {

std::string name_of(const StabilityRun& run) {
  return run.partner ? run.first->name + " + " + run.partner->name : run.first->name;
}

std::size_t count(const StabilitySeries& series, std::uint32_t flags) {
  return static_cast<std::size_t>(
      std::count_if(series.flags.begin(), series.flags.end(), [&](std::uint32_t f) { return (f & flags) != 0; }));
}

struct Result {
  const StabilityRun& run;
  const Verdict& verdict;
  const StabilitySeries& series;
  const StabilityFigures& figures;

  bool ran() const { return series.ticks() > 0; }  // it was not refused
  Cell figure(double value) const { return ran() ? value : std::numeric_limits<double>::quiet_NaN(); }
  Cell flagged(std::uint32_t flags) const { return count(series, flags); }
};

constexpr Column<Result> kColumns[] = {
    {"case", [](const Result& r) -> Cell { return r.run.first->name; }},
    {"partner", [](const Result& r) -> Cell { return r.run.partner ? r.run.partner->name : ""; }},
    {"ticks", [](const Result& r) -> Cell { return r.series.ticks(); }},
    {"pass", [](const Result& r) -> Cell { return r.verdict.pass(); }},
    {"outcome", [](const Result& r) -> Cell { return name_of(r.verdict.outcome); }},
    {"why", [](const Result& r) -> Cell { return r.verdict.why; }},
    {"flagged", [](const Result& r) { return r.flagged(kTroubles); }},
    {"excused", [](const Result& r) { return r.figure(r.figures.excused); }},
    {"laws_not_converged", [](const Result& r) { return r.flagged(kLawsNotConverged); }},
    {"newton_not_converged", [](const Result& r) { return r.flagged(kNewtonNotConverged); }},
    {"tangent_projected", [](const Result& r) { return r.flagged(kTangentProjected); }},
    {"not_finite", [](const Result& r) { return r.flagged(kNotFinite); }},
    {"step_limited", [](const Result& r) { return r.flagged(kStepLimited); }},
    {"elements_inverted", [](const Result& r) { return r.flagged(kElementsInverted); }},
    {"residual_N", [](const Result& r) { return r.figure(r.figures.residual.value); }},
    {"energy_J", [](const Result& r) { return r.figure(r.figures.largest_energy); }},
    {"energy_gain", [](const Result& r) { return r.figure(r.figures.gain.value); }},
    {"energy_rise", [](const Result& r) { return r.figure(r.figures.rise.value); }},
    {"largest_force_N", [](const Result& r) { return r.figure(r.figures.largest_force); }},
    {"alternation", [](const Result& r) { return r.figure(r.figures.alternation.value); }},
    {"untold_alternation", [](const Result& r) { return r.figure(r.figures.untold_alternation); }},
    {"smallest_volume", [](const Result& r) { return r.figure(r.series.smallest_volume); }},
    {"deepest_mm", [](const Result& r) { return r.figure(1e3 * r.series.deepest); }},
    {"intrusions", [](const Result& r) -> Cell { return r.series.intrusions; }},
    {"touched", [](const Result& r) -> Cell { return r.series.touched; }},
    {"withdrawn", [](const Result& r) -> Cell { return r.series.withdrawn; }},
    {"return", [](const Result& r) { return r.figure(r.figures.left); }},
    {"swing", [](const Result& r) { return r.figure(r.figures.swing); }},
    {"ms_per_tick",
     [](const Result& r) { return r.figure(1e3 * r.series.seconds / static_cast<double>(r.series.ticks())); }},
};

void do_run(const StabilityRun& run, const std::string& folder, CsvFile& file) {
  StabilitySeries series;
  StabilityFigures figures;
  Verdict verdict;
  try {
    const Experiment experiment = make_experiment(make_trial(run), folder);
    series = run_to_rest(experiment);
    figures = measure(series);
    verdict = judge(series, figures, experiment.scene.laws.tolerance, expected_of(run));
    if (is_refused(run)) verdict = {TrialOutcome::failed, "is not refused"};
  } catch (const SceneError& error) {
    verdict = {is_refused(run) ? TrialOutcome::refused : TrialOutcome::failed, error.what()};
  }
  file.row(cells_of(kColumns, Result{run, verdict, series, figures}));
}

}  // namespace

void study_stability(const StudyPlan& plan) {
  const std::string meshes = plan.out + "/stability_meshes";
  std::filesystem::create_directories(meshes);
  CsvFile file(plan.out + "/stability.csv", names_of(kColumns));
  std::vector<StabilityRun> runs = plan.quick ? quick_stability_runs() : stability_runs();
  if (!plan.stability_run.empty()) {
    std::erase_if(runs, [&](const StabilityRun& run) { return name_of(run) != plan.stability_run; });
    if (runs.empty()) throw std::runtime_error("no run is called '" + plan.stability_run + "'; stability.csv lists them");
  }
  const int of = static_cast<int>(runs.size());
  for (int done = 0; done < of; ++done) {
    plan.progress(done, of, name_of(runs[done]));
    do_run(runs[done], meshes, file);
  }
  std::filesystem::remove_all(meshes);
  plan.progress(of, of, "done");
}

}  // namespace acus
