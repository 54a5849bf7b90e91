// SPDX-License-Identifier: GPL-3.0-or-later
// acus-evidence: error against run time, dependence on the mesh, stability at the extremes, as tables.
#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <string>

#include "tests/study/studies/study.h"

namespace {

using namespace acus;

enum ExitCode : int { kDone = 0, kBadCommandLine = 1, kFailed = 3 };

constexpr const char* kDescription =
    "Runs many simulations in process and writes what they show as CSV tables. scripts/report runs all studies and "
    "draws the tables.";
constexpr const char* kFooter =
    "Examples:\n"
    "  acus-evidence --quick --out /tmp/study errors\n"
    "  acus-evidence --out out/report stability refinement\n"
    "  acus-evidence --out out/report errors --scene steering\n"
    "\nExit status: 0 done; 1 bad command line; 3 anything else; 4 not built for this processor.";

struct StudyCommand {
  const char* name;
  const char* meaning;
  void (*run)(const StudyPlan&);
};

constexpr StudyCommand kStudies[] = {
    {"errors", "Errors against a converged reference and run time, over every knob of a scene", study_errors},
    {"refinement", "Locking and point forces: what depends on the mesh, and what mends it", study_refinement},
    {"windows", "Deferred fields: how far forces are from those without, and how long ticks take", study_windows},
    {"entries", "Needles that go in at random places, and whether the tissue notices them", study_entries},
    {"shafts", "Thin needles that bend, slide and are swept over tissue, and whether it bears their shafts", study_shafts},
    {"holds", "Bases that stop at random moments of the scenes' motions, and how far forces jump then", study_holds},
    {"haptics", "Hands on haptic devices on needles: which loops are stable, with the kit and without it",
     study_haptics},
    {"stability", "Extreme cases and their nastiest pairs, each with a verdict", study_stability},
};

// Of FILE=METRES_PER_UNIT.
GmshMesh mesh_of(const std::string& text) {
  const auto sign = text.rfind('=');
  GmshMesh mesh{text.substr(0, sign), 0};
  if (sign == std::string::npos || !CLI::detail::lexical_cast(text.substr(sign + 1), mesh.metres_per_unit) ||
      !(mesh.metres_per_unit > 0))
    throw CLI::ValidationError("--mesh", "expected FILE=METRES_PER_UNIT, found " + text);
  return mesh;
}

// A line per run, with the time since the start.
class ProgressLine {
 public:
  explicit ProgressLine(std::string study) : study_(std::move(study)) {}

  void tell(int done, int of, const std::string& next) {
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
    std::fprintf(stderr, "acus-evidence %s: %d of %d runs, %.0f s; %s\n", study_.c_str(), done, of, seconds, next.c_str());
  }

 private:
  std::string study_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

void add_random_needles(CLI::App& study, StudyPlan& plan) {
  study.add_option("--count", plan.entries, "How many")->check(CLI::PositiveNumber)->default_str("2000");
  study.add_option("--first", plan.first_entry, "The number of the first one")->check(CLI::NonNegativeNumber);
  study.add_option_function<std::vector<std::string>>(
      "--mesh", [&](const auto& texts) { for (const std::string& text : texts) plan.meshes.push_back(mesh_of(text)); },
      "A mesh that needles go into besides blocks; may be given again")->type_name("FILE=METRES_PER_UNIT");
}

int run(const StudyCommand& study, StudyPlan plan) {
  ProgressLine line(study.name);
  plan.progress = [&line](int done, int of, const std::string& next) { line.tell(done, of, next); };
  try {
    study.run(plan);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "acus-evidence %s: %s\n", study.name, error.what());
    return kFailed;
  }
  return kDone;
}

}  // namespace

int main(int argc, char** argv) {
  StudyPlan plan;
  CLI::App app(kDescription, "acus-evidence");
  app.footer(kFooter);
  app.set_version_flag("--version", ACUS_VERSION);
  app.require_subcommand(1, 0);
  app.add_flag("--quick", plan.quick, "A short form that still goes through every kind of run");
  app.add_option("--out", plan.out, "Folder for the tables; made if it is not there")->capture_default_str();
  app.add_option("--scenes", plan.scenes, "Folder of the project's scenes")->capture_default_str();
  for (const StudyCommand& study : kStudies) app.add_subcommand(study.name, study.meaning);
  app.get_subcommand("errors")->add_option("--scene", plan.scene, "Only this one of its scenes")->default_str("all");
  app.get_subcommand("stability")
      ->add_option("--run", plan.stability_run, "Only this one: a case, or a pair as CASE + CASE")
      ->type_name("NAME")
      ->default_str("all");
  for (const char* name : {"entries", "shafts"}) add_random_needles(*app.get_subcommand(name), plan);
  CLI::App& haptics = *app.get_subcommand("haptics");
  haptics.add_option("--table", plan.haptics_table, "Name of its table")->capture_default_str();
  CLI::Option* part = haptics.add_option("--part", plan.part, "Of its runs, every PARTSth from this number on")
                          ->check(CLI::NonNegativeNumber);
  haptics.add_option("--parts", plan.parts, "So that several processes share the runs")
      ->check(CLI::PositiveNumber)->needs(part);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kDone : kBadCommandLine;
  }
  std::error_code trouble;
  std::filesystem::create_directories(plan.out, trouble);
  for (const StudyCommand& study : kStudies) {
    if (!app.got_subcommand(study.name)) continue;
    if (const int code = run(study, plan); code != kDone) return code;
  }
  return kDone;
}
