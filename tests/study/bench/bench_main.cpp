// SPDX-License-Identifier: GPL-3.0-or-later
// acus-bench: how long the ticks of a scene take on one core, beside a calibration in the same run.
#include <sched.h>
#include <sys/resource.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <functional>
#include <optional>
#include <stdexcept>
#include <string>
#include <system_error>

#include "client/replay/log_file.h"
#include "client/replay/timing_limits.h"
#include "protocol/own_file.h"
#include "server/engine/math/kernel_set.h"
#include "server/engine/scene/scene_fields.h"
#include "tests/study/bench/bench_report.h"

namespace {

using namespace acus;

enum ExitCode : int { kDone = 0, kBadCommandLine = 1, kBadInput = 2, kFailed = 3, kLimitExceeded = 5 };

constexpr const char* kDescription =
    "Runs a scene along a trajectory without sockets, as fast as it goes on one core, and prints how long each "
    "stage of the tick took.\nBlocks of 200 ticks take turns with a calibration: 20 runs each of CHOLMOD's own forward "
    "and backward solve of the tissue's matrix, ordered as the simulation orders it and again in CHOLMOD's default "
    "order, and of a dense Cholesky factorisation. The first 5 ticks and 4 runs after a change are not counted, since "
    "the caches hold the other's data. Compare the ratios: absolute times of shared machines drift. Where others run "
    "on the same processor, processor times and their ratios, which leave theirs out, tell more than those by the "
    "clock.";
constexpr const char* kFooter =
    "Examples:\n"
    "  acus-bench scenes/benchmark/cube_1000.yaml scenes/benchmark/insertion_60mm.csv\n"
    "  acus-bench SCENE TRAJECTORY --needle rigid\n"
    "                                            what the needle's bending costs: stages 2 and 6 against a run "
    "without\n"
    "  acus-bench SCENE TRAJECTORY --rung linear --solver direct --json linear.json\n"
    "  acus-bench scenes/benchmark/rows_200.yaml scenes/benchmark/insertion_60mm.csv --min-rows 200\n"
    "                                            count only ticks with so many rows of laws\n"
    "  acus-bench SCENE TRAJECTORY --skip 0.5 --repeat 5\n"
    "                                            five times through, each without its first half second\n"
    "  acus-bench SCENE TRAJECTORY --rung exact --ticks 200 --json - | jq .tick\n"
    "  acus-bench SCENE TRAJECTORY --quiet --max-p99-ms 0.8       exit status 5 if 1 tick of 100 takes longer\n"
    "  acus-bench scenes/benchmark/cube_1000.yaml scenes/benchmark/insertion_60mm.csv --against "
    "tests/benchmarks/history.csv\n"
    "                                            exit status 5 if a ratio is 10 % worse than it was\n"
    "  ACUS_INSTRUCTION_SET=v3 acus-bench SCENE TRAJECTORY        as on a processor without AVX-512\n"
    "\nExit status: 0 measured; 1 bad command line; 2 the scene or the trajectory cannot be used, or no "
    "tick counted; 3 anything else; 4 not built for this processor; 5 a limit on\nthe timing was exceeded, or a ratio "
    "is worse than in --against.";

constexpr const char* kNothingCounted =
    "no tick counted, so there are no times: the first 5 ticks of each 200 never do; ask for more --ticks, a shorter "
    "--skip or fewer --min-rows";

struct Arguments {
  std::string scene, trajectory, json, against;
  std::optional<TissueRung> rung;
  std::optional<LawMethod> solver;
  std::optional<NeedleRung> needle;
  std::optional<int> core;
  MeasurementPlan plan;
  client::TimingLimits limits;
  bool no_calibration = false;
  bool quiet = false;
};

// A choice by one of its names in scene files.
template <class Enum>
void add_choice(CLI::App& app, const std::string& name, std::optional<Enum>& value, const std::string& meaning) {
  const auto& names = NamesOf<Enum>::names;
  const auto set = [&value, &names](const std::string& text) {
    value = static_cast<Enum>(std::find(names.begin(), names.end(), text) - names.begin());
  };
  app.add_option_function<std::string>(name, set, meaning)
      ->check(CLI::IsMember(std::vector<std::string>(names.begin(), names.end())));
}

void declare(CLI::App& app, Arguments& arguments) {
  app.footer(kFooter);
  app.set_version_flag("--version", ACUS_VERSION);
  app.add_option("SCENE", arguments.scene, "Scene file (YAML); scenes/README.md describes the format")->required();
  app.add_option("TRAJECTORY", arguments.trajectory, "Motion of the needles' bases (CSV), as for acus-replay")
      ->required();
  add_choice(app, "--rung", arguments.rung, "How the tissue is solved, instead of the scene's own tissue.rung");
  add_choice(app, "--solver", arguments.solver, "How the laws are solved, instead of the scene's own laws.solver");
  add_choice(app, "--needle", arguments.needle, "How all needles bend, instead of their own needles[].rung");
  app.add_option("--json", arguments.json, "Write the results to this file, too; - prints them instead of the table");
  app.add_option("--against", arguments.against,
                 "Compare with the last measurement of this scene on such a processor in this file (CSV, like "
                 "tests/benchmarks/history.csv); where there is none, say so");
  app.add_option("--core", arguments.core, "Processor to run on")->default_str("the last one allowed");
  app.add_option("--ticks", arguments.plan.max_ticks, "End each time through after so many ticks")
      ->check(CLI::PositiveNumber)
      ->default_str("all of the trajectory");
  app.add_option("--repeat", arguments.plan.repeat, "Times through the trajectory, each from the scene's start")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  app.add_option("--skip", arguments.plan.skip, "Seconds at the start of each time through that are not counted")
      ->check(CLI::Range(0.0, 1e6))
      ->capture_default_str();
  app.add_option("--min-rows", arguments.plan.min_rows, "Count only ticks with at least so many rows of laws")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  declare(app, arguments.limits, "a tick");
  app.add_flag("--no-calibration", arguments.no_calibration, "Run the ticks alone, without anything to compare with")
      ->excludes("--against");
  app.add_flag("--quiet", arguments.quiet, "Print nothing but errors");
}

// Runs this thread on one processor: `wanted`, or the last one it may run on, which devices interrupt least.
int pin_to_core(std::optional<int> wanted) {
  cpu_set_t allowed;
  if (sched_getaffinity(0, sizeof allowed, &allowed) != 0)
    throw std::system_error(errno, std::system_category(), "affinity");
  int core = wanted.value_or(CPU_SETSIZE - 1);
  while (!wanted && core > 0 && !CPU_ISSET(core, &allowed)) --core;
  cpu_set_t one;
  CPU_ZERO(&one);
  if (core >= 0 && core < CPU_SETSIZE) CPU_SET(core, &one);
  if (sched_setaffinity(0, sizeof one, &one) != 0)
    throw std::runtime_error("--core: processor " + std::to_string(core) +
                             " cannot be used here; nproc tells how many there are");
  return core;
}

double peak_memory() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return 1024.0 * static_cast<double>(usage.ru_maxrss);
}

Scene read_scene_as_asked(const Arguments& arguments) {
  Scene scene = read_scene(arguments.scene);
  if (arguments.rung) scene.tissue.rung = *arguments.rung;
  if (arguments.solver) scene.laws.solver = *arguments.solver;
  if (arguments.needle == NeedleRung::rigid && !scene.guides.empty())
    throw std::runtime_error("--needle rigid: the scene has guides, which hold flexible needles; leave the option out");
  if (arguments.needle)
    for (Needle& needle : scene.needles) needle.rung = *arguments.needle;
  return scene;
}

using Say = std::function<void(const std::string&)>;

// What is measured, as loaded.
struct Experiment {
  Simulation simulation;
  TrajectoryDriver driver;

  Experiment(const Arguments& arguments, const Say& say)
      : simulation(read_scene_as_asked(arguments), [&](const char* what) { say(std::string("loading: ") + what); }),
        driver(simulation, client::read_trajectory(arguments.trajectory)) {}
};

Measurement measure_telling(Experiment& experiment, Calibration& calibration, const MeasurementPlan& plan,
                            const Say& say) {
  std::uint64_t told = 0;  // tenths
  const auto tell = [&](std::uint64_t done, std::uint64_t of) {
    const std::uint64_t tenths = 10 * done / of;
    if (tenths > told) say("tick " + std::to_string(done) + " of " + std::to_string(of));
    told = tenths;
  };
  return measure(experiment.simulation, experiment.driver, calibration, plan, tell);
}

Calibration prepare_calibration(const Arguments& arguments, const Simulation& simulation, const Say& say) {
  if (arguments.no_calibration) return {};
  say("factorising for the calibration");
  return Calibration(simulation);
}

void print(const Arguments& arguments, const BenchRun& run, const Simulation& simulation,
           const Calibration& calibration, std::optional<client::LogFile>& file) {
  const std::string json = bench_json(run, simulation, calibration);
  if (arguments.json == "-") {
    std::fputs(json.c_str(), stdout);
    return;
  }
  if (!arguments.quiet) std::fputs(bench_table(run, simulation, calibration).c_str(), stdout);
  if (!file) return;
  file->out() << json;
  file->close();
}

// A tick that takes longer than the time that it simulates would be late.
client::MeasuredTiming timing_of(const std::vector<double>& ticks, const Simulation& simulation) {
  const double period = 1 / simulation.scene().rate;
  const auto late = std::count_if(ticks.begin(), ticks.end(), [&](double seconds) { return seconds > period; });
  return {1e3 * static_cast<double>(late) / static_cast<double>(ticks.size()), client::distribution_of(ticks)};
}

// Whether no ratio is much worse than it was; true where nothing was measured on such a processor.
bool held_against(const Arguments& arguments, const std::vector<HistoryRow>& history, const HistoryRow& now) {
  const std::optional<HistoryRow> before = last_comparable(history, now);
  if (!before) {
    std::fprintf(stderr, "acus-bench: %s has no measurement of %s on %s with kernels %s\n", arguments.against.c_str(),
                 now.scene.c_str(), now.processor.c_str(), now.kernels.c_str());
    return true;
  }
  bool held = true;
  for (const RatioComparison& ratio : compare(*before, now)) {
    held = held && ratio.held();
    if (ratio.held() && arguments.quiet) continue;
    std::fprintf(stderr, "acus-bench: %s %.3f, %.3f at %s (%s): %+.1f %%%s\n", ratio.name, ratio.now, ratio.before,
                 before->commit.c_str(), before->date.c_str(), 100 * ratio.worse(),
                 ratio.held() ? "" : ", worse than the 10 % that are allowed");
  }
  return held;
}

int run(const Arguments& arguments) {
  const Say say = [&](const std::string& text) {
    if (!arguments.quiet) std::fprintf(stderr, "acus-bench: %s\n", text.c_str());
  };
  BenchRun run;
  run.scene_file = arguments.scene;
  run.trajectory_file = arguments.trajectory;
  run.core = pin_to_core(arguments.core);
  std::optional<client::LogFile> json;  // before anything is measured
  if (!arguments.json.empty() && arguments.json != "-") json.emplace(arguments.json, protocol::json_of_acus());
  const std::vector<HistoryRow> history =
      arguments.against.empty() ? std::vector<HistoryRow>() : read_history(arguments.against);

  std::optional<Experiment> experiment;
  try {
    const auto start = std::chrono::steady_clock::now();
    experiment.emplace(arguments, say);
    run.load_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    run.peak_memory = peak_memory();
  } catch (const std::runtime_error& error) {
    std::fprintf(stderr, "acus-bench: %s\n", error.what());
    return kBadInput;
  }
  Calibration calibration = prepare_calibration(arguments, experiment->simulation, say);
  run.measured = measure_telling(*experiment, calibration, arguments.plan, say);
  print(arguments, run, experiment->simulation, calibration, json);
  if (run.measured.times.whole.wall.empty()) {
    std::fprintf(stderr, "acus-bench: %s\n", kNothingCounted);
    return kBadInput;
  }
  const auto limits = compare(arguments.limits, timing_of(run.measured.times.whole.wall, experiment->simulation));
  const bool as_fast =
      arguments.against.empty() || held_against(arguments, history, history_row(run, experiment->simulation));
  return all_held("acus-bench", limits) && as_fast ? kDone : kLimitExceeded;
}

}  // namespace

int main(int argc, char** argv) {
  Arguments arguments;
  CLI::App app(kDescription, "acus-bench");
  declare(app, arguments);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kDone : kBadCommandLine;
  }
  try {
    kernel_set();  // complains
  } catch (const std::runtime_error& error) {
    std::fprintf(stderr, "acus-bench: %s\n", error.what());
    return kBadCommandLine;
  }
  try {
    return run(arguments);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "acus-bench: %s\n", error.what());
    return kFailed;
  }
}
