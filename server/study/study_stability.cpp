// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <optional>

#include "server/study/csv.h"
#include "server/study/stability_cases.h"
#include "server/study/stability_run.h"
#include "server/study/study.h"

namespace acus {

namespace {

constexpr std::size_t kQuickRuns = 25;

const std::vector<std::string> kColumns{
    "case",        "partner",       "ticks",        "pass",
    "outcome",     "why",           "flagged",      "laws_not_converged",
    "newton_not_converged", "tangent_projected", "not_finite", "residual_N",
    "energy_J",    "energy_gain",   "energy_rise",  "largest_force_N",
    "alternation", "withdrawn",     "return",       "ms_per_tick"};

// A folder for meshes, gone with its owner.
class TemporaryFolder {
 public:
  explicit TemporaryFolder(const std::string& path) : path_(path) { std::filesystem::create_directories(path_); }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

std::string name_of(const StabilityRun& run) {
  return run.partner ? run.first->name + " + " + run.partner->name : run.first->name;
}

// Every so many, so that all kinds of runs are among them.
std::vector<StabilityRun> quick(const std::vector<StabilityRun>& all) {
  std::vector<StabilityRun> some;
  const std::size_t stride = (all.size() + kQuickRuns - 1) / kQuickRuns;
  for (std::size_t i = 0; i < all.size(); i += stride) some.push_back(all[i]);
  return some;
}

std::size_t count(const StabilitySeries& series, std::uint32_t flags) {
  return static_cast<std::size_t>(
      std::count_if(series.flags.begin(), series.flags.end(), [&](std::uint32_t f) { return (f & flags) != 0; }));
}

void write_row(CsvFile& file, const StabilityRun& run, const Verdict& verdict, const StabilitySeries& series) {
  const StabilityFigures f = measure(series);
  const auto ticks = static_cast<double>(series.ticks());
  const double nothing = std::numeric_limits<double>::quiet_NaN();
  const auto number = [&](double value) { return Cell(series.ticks() > 0 ? value : nothing); };
  file.row({run.first->name, run.partner ? run.partner->name : "", series.ticks(), verdict.pass(),
            name_of(verdict.outcome), verdict.why, count(series, ~0u), count(series, kLawsNotConverged),
            count(series, kNewtonNotConverged), count(series, kTangentProjected), count(series, kNotFinite),
            number(f.residual.value), number(f.largest_energy), number(f.gain.value), number(f.rise.value),
            number(f.largest_force), number(f.alternation.value), series.withdrawn,
            series.withdrawn ? number(f.left) : Cell(nothing), number(1e3 * series.seconds / ticks)});
}

void do_run(const StabilityRun& run, const std::string& folder, CsvFile& file) {
  StabilitySeries series;
  Verdict verdict;
  const bool refuse = run.first->refuse || (run.partner && run.partner->refuse);
  try {
    const Experiment experiment = make_experiment(make_trial(run), folder);
    series = run_to_rest(experiment);
    verdict = judge(series, measure(series), experiment.scene.laws.tolerance);
    if (refuse) verdict = {Outcome::failed, "is not refused"};
  } catch (const SceneError& error) {
    verdict = {refuse ? Outcome::refused : Outcome::failed, error.what()};
  }
  write_row(file, run, verdict, series);
}

}  // namespace

void study_stability(const StudyPlan& plan) {
  const TemporaryFolder meshes(plan.out + "/stability_meshes");
  CsvFile file(plan.out + "/stability.csv", kColumns);
  const std::vector<StabilityRun> all = stability_runs();
  const std::vector<StabilityRun> runs = plan.quick ? quick(all) : all;
  const int of = static_cast<int>(runs.size());
  for (int done = 0; done < of; ++done) {
    plan.progress(done, of, name_of(runs[done]));
    do_run(runs[done], meshes.path(), file);
  }
  plan.progress(of, of, "done");
}

}  // namespace acus
