// SPDX-License-Identifier: GPL-3.0-or-later
// acus-export: runs a recording again, says whether it comes out the same, and writes what comes out for other programs.
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cinttypes>
#include <csignal>
#include <cstdio>
#include <limits>
#include <optional>

#include "client/link/program.h"
#include "client/replay/run_log.h"
#include "client/replay/same_file.h"
#include "server/engine/recording/rerun.h"
#include "server/export/messages_export.h"
#include "server/export/shapes_export.h"
#include "server/export/vtk_export.h"
#include "server/runtime/convert.h"

namespace {

using namespace acus;

enum ExitCode : int { kSame = 0, kBadArguments = 1, kUnusable = 2, kCannotWrite = 3, kDiffers = 4, kDamaged = 5 };

constexpr double kVtkRate = 30, kMessagesRate = 60;  // Hz, of frames, unless told otherwise

constexpr const char* kDescription =
    "Runs a recording of acus-server again and says whether it comes out the same to the last bit; writes the forces as "
    "CSV, and the shapes for client/picture, for Python, for ParaView and for viewers.";
constexpr const char* kFooter =
    "Examples:\n"
    "  acus-export RUN                      does this machine make the same of it?\n"
    "  acus-export RUN --csv run.csv        forces and events, as acus-replay --out writes them\n"
    "  acus-export RUN --csv run.csv --shapes run.shapes    then client/picture run.csv draws it\n"
    "  acus-export RUN --vtk frames         open frames/tissue.pvd, needles.pvd, paths.pvd in ParaView\n"
    "  acus-export RUN --messages run.messages    the messages of the protocol that a viewer needs to show the run\n"
    "\nExit status: 0 it comes out the same, 1 bad arguments, 2 the recording cannot be used, 3 a file cannot be written,\n"
    "4 it comes out otherwise, and the first tick that does is named, 5 a part of it is damaged or not whole: what stands\n"
    "before comes out the same.";

struct Arguments {
  std::string recording;
  std::string csv;
  std::string shapes;
  std::string vtk;
  std::string messages;
  std::optional<double> rate;  // Hz, of frames
  bool quiet = false;
};

// For CLI::Option::check().
std::string check_rate(const std::string& text) {
  double rate = 0;
  const bool good = CLI::detail::lexical_cast(text, rate) && rate >= 0.001 && rate <= 1e6;  // NaN is not
  return good ? "" : "expected a number from 0.001 to 1e6, found '" + text + "'";
}

void declare(CLI::App& app, Arguments& arguments) {
  app.footer(kFooter);
  app.set_version_flag("--version", ACUS_VERSION);
  app.add_option("RECORDING", arguments.recording, "What acus-server --record or a client's 'record' wrote")
      ->required()
      ->check(CLI::ExistingFile);
  app.add_option("--csv", arguments.csv, "CSV to write, a row per tick and needle; events go to NAME.events.csv beside it")
      ->type_name("FILE");
  app.add_option("--shapes", arguments.shapes,
                 "File to write with the shapes of needles and tissue, as acus-replay --shapes writes them; of the first "
                 "scene, where a client loaded another one")
      ->type_name("FILE");
  app.add_option("--vtk", arguments.vtk, "Folder for VTK files; it is made where it is not there")->type_name("FOLDER");
  app.add_option("--messages", arguments.messages,
                 "File to write with the server's messages that show the run, frame by frame, usable while it grows; of "
                 "the first scene, where a client loaded another one")
      ->type_name("FILE");
  app.add_option("--rate", arguments.rate, "Frames per second of simulation time (Hz), for --vtk and --messages")
      ->check(check_rate)
      ->default_str("30 for --vtk, 60 for --messages");
  app.callback([&arguments] {
    if (arguments.rate && arguments.vtk.empty() && arguments.messages.empty())
      throw CLI::RequiresError("--rate", "--vtk or --messages");
  });
  app.add_flag("--quiet", arguments.quiet, "Print nothing but errors");
}

// One line on a terminal, rewritten ten times a second of simulation.
class Progress {
 public:
  explicit Progress(bool wanted) : shown_(wanted && isatty(STDERR_FILENO) == 1) {}

  void show(const Rerun& rerun) {
    if (!shown_ || rerun.seconds() < next_) return;
    next_ = rerun.seconds() + 0.1;
    std::fprintf(stderr, "\r%8.1f s, %" PRIu64 " ticks\033[K", rerun.seconds(), rerun.ticks());
  }
  ~Progress() {
    if (next_ > 0) std::fputs("\r\033[K", stderr);
  }

 private:
  bool shown_;
  double next_ = 0;  // s
};

// What a recording does not tell is no number.
void write(client::RunLog& log, const Rerun& rerun) {
  constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  for (int i = 0; i < needle_count(rerun); ++i) {
    protocol::Force force = force_of(rerun, i);
    force.age = force.echo = force.fresh = kUnknown;
    force.haptic_force.fill(kUnknown);
    force.haptic_torque.fill(kUnknown);
    log.write(force, 0);
  }
  const TickReport& report = rerun.simulation().report();
  for (const Event& event : report.events)
    log.write(to_wire(event, rerun.epoch(), report.time, rerun.simulation().scene()));
}

// Of a recording, which may be anybody's: on one line, and not endless.
std::string shown(const std::string& text) {
  constexpr std::size_t kMost = 200;
  std::string line = text.substr(0, kMost);
  for (char& c : line)
    if (c < ' ' || c > '~') c = '?';
  return line;
}

void print(const Rerun& rerun, const std::string& file) {
  std::printf("recording   %s, by acus-server %s, %s\n", file.c_str(), shown(rerun.opening().server).c_str(),
              shown(rerun.opening().started).c_str());
  std::printf("run again   %" PRIu64 " ticks, %.3f s of simulation time\n", rerun.ticks(), rerun.seconds());
  if (!rerun.problem().empty()) std::printf("its end     %s\n", shown(rerun.problem()).c_str());
  const std::optional<Difference>& difference = rerun.difference();
  if (!difference) {
    std::printf("outcome     the same to the last bit%s\n", rerun.damaged() ? ", as far as it can be read" : "");
  } else if (difference->reported) {
    std::printf("outcome     differs from tick %" PRIu64 " of epoch %" PRIu64 " on\n", difference->tick, difference->epoch);
  } else {
    std::printf("outcome     differs: the state after tick %" PRIu64 " of epoch %" PRIu64
                " is another one; what ticks told was the same up to there\n",
                difference->tick, difference->epoch);
  }
}

struct Result {
  const char* option;
  std::string path;
};

std::vector<Result> results_of(const Arguments& arguments) {
  std::vector<Result> results;
  if (!arguments.csv.empty())
    results = {{"--csv", arguments.csv}, {"--csv", client::RunLog::events_path_beside(arguments.csv)}};
  if (!arguments.shapes.empty()) results.push_back({"--shapes", arguments.shapes});
  if (!arguments.messages.empty()) results.push_back({"--messages", arguments.messages});
  return results;
}

// Throws if a result were to go into the recording, or into another result.
void check_distinct(const Arguments& arguments) {
  const std::vector<Result> results = results_of(arguments);
  for (std::size_t i = 0; i < results.size(); ++i) {
    const auto& [option, path] = results[i];
    if (client::same_file(path, arguments.recording))
      throw std::runtime_error(std::string(option) + " would overwrite the recording, '" + path + "'; give it another name");
    for (std::size_t other = i + 1; other < results.size(); ++other)
      if (client::same_file(path, results[other].path))
        throw std::runtime_error(std::string(option) + " and " + results[other].option +
                                 " would write the same file, '" + path + "'; give one another name");
  }
}

int run(const Arguments& arguments) {
  check_distinct(arguments);
  Rerun rerun(arguments.recording);
  std::optional<client::RunLog> csv;
  if (!arguments.csv.empty()) csv.emplace(arguments.csv, false);
  std::optional<ShapesExport> shapes;
  if (!arguments.shapes.empty()) shapes.emplace(arguments.shapes, rerun);
  std::optional<VtkExport> vtk;
  if (!arguments.vtk.empty()) vtk.emplace(arguments.vtk, arguments.rate.value_or(kVtkRate));
  std::optional<MessagesExport> messages;
  if (!arguments.messages.empty()) messages.emplace(arguments.messages, arguments.rate.value_or(kMessagesRate), rerun);
  {
    Progress progress(!arguments.quiet);
    while (rerun.step()) {
      if (csv) write(*csv, rerun);
      if (shapes) shapes->take(rerun);
      if (vtk) vtk->take(rerun);
      if (messages) messages->take(rerun);
      progress.show(rerun);
    }
  }
  if (csv) csv->close();
  if (shapes) shapes->close();
  if (vtk) vtk->close();
  if (messages) messages->close(rerun);
  if (!arguments.quiet) print(rerun, arguments.recording);
  if (rerun.difference()) return kDiffers;
  if (rerun.damaged()) std::fprintf(stderr, "acus-export: %s: %s\n", arguments.recording.c_str(), rerun.problem().c_str());
  return rerun.damaged() ? kDamaged : kSame;
}

int status_of(const std::exception& error) {
  const bool unusable =
      dynamic_cast<const RecordingError*>(&error) != nullptr || dynamic_cast<const SceneError*>(&error) != nullptr;
  return unusable ? kUnusable : kCannotWrite;
}

}  // namespace

int main(int argc, char** argv) {
  std::signal(SIGXFSZ, SIG_IGN);  // a file that may not grow is an error
  Arguments arguments;
  CLI::App app(kDescription, "acus-export");
  declare(app, arguments);
  return client::run_program(
      app, argc, argv, [&] { return run(arguments); }, status_of);
}
