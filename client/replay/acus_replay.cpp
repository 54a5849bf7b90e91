// SPDX-License-Identifier: MIT
// acus-replay: drives a recorded trajectory into an acus-server, writes what comes back, and sums it up.
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <exception>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "client/link/command_line.h"
#include "client/link/priority.h"
#include "client/link/program.h"
#include "client/replay/log_file.h"
#include "client/replay/replay.h"
#include "client/replay/run_summary.h"
#include "client/replay/same_file.h"
#include "client/replay/text_histogram.h"
#include "client/replay/timing_log.h"
#include "protocol/own_file.h"
#include "protocol/printable.h"

namespace {

using namespace acus::client;

constexpr int kStatesLost = 4, kLimitExceeded = 7;  // and those of client/link/program.h

constexpr const char* kFooter =
    "Exit status: 0 done, 1 bad arguments, files or trajectory, 2 the server refused, 3 the server was not there or\n"
    "vanished, 4 states were lost, 5 the server speaks another protocol, 6 interrupted,\n"
    "7 a limit on the timing was exceeded. A recording of a server ends as acus-export does.";

struct Arguments {
  KeyFiles keys;
  std::string trajectory;
  std::string out;
  std::string shapes;
  std::string timing;
  std::string summary;
  TimingLimits limits;
  double timeout_s = 10;
  ReplayOptions replay;
};

void declare(CLI::App& app, Arguments& arguments) {
  app.footer(kFooter);
  app.set_version_flag("--version", ACUS_VERSION);
  app.add_option(
         "trajectory", arguments.trajectory,
         "CSV with the columns t,needle,x,y,z,qw,qx,qy,qz[,spin]; 'needle' may name a guide, too. A recording of "
         "a server (acus-server --record) is handed to acus-export, which runs it again")
      ->required();
  app.add_option("--commands", arguments.replay.commands, "the server's endpoint for commands")
      ->check(check_endpoint)
      ->capture_default_str();
  app.add_option("--states", arguments.replay.states, "the server's endpoint for states")
      ->check(check_endpoint)
      ->capture_default_str();
  declare_keys(app, arguments.keys);
  app.add_option("--out", arguments.out, "CSV to write, a row per force state; events go to NAME.events.csv beside it");
  app.add_option("--shapes", arguments.shapes,
                 "file to write with the shapes of needles and tissue, as protocol/README.md says; after --out RUN.csv "
                 "--shapes RUN.shapes, client/picture RUN.csv draws the run");
  CLI::Option* timing =
      app.add_option("--timing", arguments.timing,
                     "CSV to write, a row per pose with its round trip, in real time; the server's punctuality goes to "
                     "NAME.stats.csv beside it, client/plot NAME.csv draws both");
  app.add_option("--passes", arguments.replay.passes, "through the trajectory, every second one backwards")
      ->check(CLI::Range(1, 1'000'000))
      ->capture_default_str();
  app.add_option("--rate", arguments.replay.rate, "poses per second (Hz); default: the server's ticks per second")
      ->check(within(1.0, 100'000.0));
  app.add_option("--timeout", arguments.timeout_s, "to wait for the server to appear, to answer or to publish (s)")
      ->check(within(0.001, 86'400.0))
      ->capture_default_str();
  app.add_option("--summary", arguments.summary, "file to write with what is printed at the end, as JSON");
  CLI::App& limits = declare(app, arguments.limits, "the round trip from a pose to the first state that used it");
  limits.excludes(
      app.add_flag("--lockstep", arguments.replay.lockstep, "one tick per pose, for a server that runs in lockstep")
          ->excludes(timing));
  app.add_flag("--shutdown", arguments.replay.shutdown, "end the server after the run");
}

// Of a server or a file, which may be anybody's.
std::string shown(const std::string& text) { return acus::protocol::printable(text); }

// One line on a terminal, rewritten ten times a second of simulation.
class Progress {
 public:
  explicit Progress(double duration) : duration_(duration), shown_(isatty(STDERR_FILENO) == 1) {}

  void show(const acus::protocol::Force& force) {
    if (!shown_ || (last_ && force.time - *last_ < 0.1)) return;
    if (!last_) first_ = force.time;
    last_ = force.time;
    std::fprintf(stderr, "\r%6.1f of %.1f s, needle '%s': depth %5.1f mm, axial resistance %6.2f N\033[K",
                 force.time - first_, duration_, shown(force.needle).c_str(), 1e3 * force.depth,
                 -force.base_force_in_base[0]);
  }

  void clear() const {
    if (last_) std::fputs("\r\033[K", stderr);
  }

 private:
  double duration_;  // s
  bool shown_;
  double first_ = 0;            // s, simulation time of the first line
  std::optional<double> last_;  // s, simulation time of the newest line
};

void print_needles(const RunStatistics& statistics) {
  for (const auto& [name, run] : statistics.needles()) {
    const auto& peak = run.extremes;
    std::printf(
        "needle '%s': deepest %.1f mm; peak axial resistance %.3f N going in, %.3f N coming out;\n"
        "            peak lateral force %.3f N, peak torque %.4f N m\n",
        shown(name).c_str(), 1e3 * peak.depth, peak.push, peak.pull, peak.lateral, peak.torque);
  }
}

void print_solvers_and_flags(const RunStatistics& statistics) {
  const auto& solved = statistics.solved();
  for (std::size_t i = 0; i < solved.size(); ++i) {
    if (solved[i] == 0) continue;
    std::printf("laws        solved by %s in %llu states\n", acus::protocol::kLawSolverNames[i],
                static_cast<unsigned long long>(solved[i]));
  }
  const auto& flagged = statistics.flagged();
  for (std::size_t bit = 0; bit < flagged.size(); ++bit) {
    if (flagged[bit] == 0) continue;
    std::printf("flag        %s in %llu states\n", acus::protocol::kFlagNames[bit],
                static_cast<unsigned long long>(flagged[bit]));
  }
}

// How punctual both sides were, and how long a pose took to be felt.
void print_timing(const Replay& replay, bool punctual) {
  const auto& server = replay.statistics().punctuality();
  std::printf("ticks       %llu late of %llu; they began up to %.3f ms after they were due, and ended up to %.3f ms\n",
              static_cast<unsigned long long>(server.late), static_cast<unsigned long long>(server.ticks),
              1e3 * server.wake_max, 1e3 * server.end_max);
  std::vector<double> times;
  for (const RoundTrip& trip : replay.round_trips()) times.push_back(trip.seconds);
  const auto trips = distribution_of(times);
  std::printf(
      "round trip  p50 %.3f ms, p99 %.3f ms, max %.3f ms, from a pose to the first state that used it%s\n"
      "            a tick ends %.3f ms after it is due, the way there and back takes %.3f ms (medians)\n",
      1e3 * trips.p50, 1e3 * trips.p99, 1e3 * trips.max, punctual ? "" : " (no real-time priority here)",
      1e3 * server.end_p50, 1e3 * replay.transit());
  std::fputs(text_histogram(std::move(times)).c_str(), stdout);
}

void print_summary(const Replay& replay, const ReplayOptions& options, bool punctual) {
  const auto& statistics = replay.statistics();
  std::printf("scene       %s\n", shown(replay.server().scene).c_str());
  if (options.lockstep) {
    std::printf("rate        lockstep, %.0f ticks per second of simulation\n", replay.server().rate);
  } else {
    std::printf("rate        %.1f Hz held of %.0f Hz, %llu overruns\n", statistics.rate(), replay.server().rate,
                static_cast<unsigned long long>(statistics.overruns()));
  }
  std::printf("poses       %llu sent, %llu deadlines missed here, %llu messages rejected there\n",
              static_cast<unsigned long long>(replay.poses_sent()),
              static_cast<unsigned long long>(replay.deadlines_missed()),
              static_cast<unsigned long long>(statistics.rejections()));
  std::printf("states      %llu received, %llu lost; %llu events\n",
              static_cast<unsigned long long>(statistics.states()), static_cast<unsigned long long>(statistics.lost()),
              static_cast<unsigned long long>(statistics.events()));
  print_solvers_and_flags(statistics);
  print_needles(statistics);
  if (!options.lockstep) print_timing(replay, punctual);
}

// Runs; how it ended, as an exit code.
int run(Replay& replay) {
  return told_status(
      "acus-replay",
      [&] {
        replay.run();
        return kDone;
      },
      [](const std::exception& error) {
        const bool interrupted = dynamic_cast<const Interrupted*>(&error) != nullptr;
        return status_of_link(error).value_or(interrupted ? kInterrupted : kBadInput);
      });
}

// Throws if two results were to go to the same file, or one into the trajectory.
void check_distinct(const Arguments& arguments) {
  struct File {
    std::string what, path;
  };
  std::vector<File> results;
  if (!arguments.out.empty()) {
    results.push_back({"--out", arguments.out});
    results.push_back({"the events of --out", RunLog::events_path_beside(arguments.out)});
  }
  if (!arguments.shapes.empty()) results.push_back({"--shapes", arguments.shapes});
  if (!arguments.summary.empty()) results.push_back({"--summary", arguments.summary});
  if (!arguments.timing.empty()) {
    results.push_back({"--timing", arguments.timing});
    results.push_back({"the statistics of --timing", TimingLog::stats_path_beside(arguments.timing)});
  }
  for (std::size_t i = 0; i < results.size(); ++i) {
    const auto& [what, path] = results[i];
    if (same_file(path, arguments.trajectory)) {
      throw std::runtime_error(what + " would overwrite the trajectory: '" + path + "' and '" + arguments.trajectory +
                               "' are the same file; give it another name");
    }
    for (std::size_t j = 0; j < i; ++j) {
      if (!same_file(path, results[j].path)) continue;
      throw std::runtime_error(results[j].what + " and " + what + " name the same file, '" + path +
                               "'; give each its own");
    }
  }
}

int replay_trajectory(Arguments& arguments) {
  check_distinct(arguments);
  arguments.replay.keys = read_keys(arguments.keys);
  const auto trajectory = read_trajectory(arguments.trajectory);
  std::printf("read        %s: %s\n", shown(arguments.trajectory).c_str(), told(trajectory).c_str());
  arguments.replay.interrupt = &catch_signals();  // from here on a signal ends the run, not the program
  std::optional<RunLog> log;
  if (!arguments.out.empty()) log.emplace(arguments.out, !arguments.replay.lockstep);
  std::optional<ShapeLog> shapes;
  if (!arguments.shapes.empty()) shapes.emplace(arguments.shapes);

  std::optional<TimingLog> timing;
  if (!arguments.timing.empty()) timing.emplace(arguments.timing);

  std::optional<LogFile> summary;
  if (!arguments.summary.empty()) summary.emplace(arguments.summary, acus::protocol::json_of_acus());

  const bool punctual = arguments.replay.lockstep || acus::client::raise_priority();
  Progress progress(arguments.replay.passes * (trajectory.end() - trajectory.begin()));
  if (timing) arguments.replay.on_stats = [&](const auto& stats, double received) { timing->write(stats, received); };
  arguments.replay.on_state = [&](const acus::protocol::Force& force) { progress.show(force); };
  Replay replay(trajectory, arguments.replay, log ? &*log : nullptr, shapes ? &*shapes : nullptr);
  int code = run(replay);
  progress.clear();
  if (replay.statistics().states() > 0) print_summary(replay, arguments.replay, punctual);
  if (log && log->begun()) {
    log->close();
    std::printf("written     %s, %s\n", log->path().c_str(), log->events_path().c_str());
  }
  if (shapes && shapes->begun()) {
    shapes->close();
    std::printf("written     %s, %llu shapes, %llu lost\n", shapes->path().c_str(),
                static_cast<unsigned long long>(shapes->shapes()), static_cast<unsigned long long>(shapes->lost()));
  }
  if (timing && (timing->begun() || replay.statistics().states() > 0)) {
    timing->write(replay.round_trips());
    timing->close();
    std::printf("written     %s, %s\n", timing->path().c_str(), timing->stats_path().c_str());
  }
  const MeasuredTiming measured = measured_timing(replay);
  const std::vector<TimingLimit> limits = compare(arguments.limits, measured);
  if (summary && replay.statistics().states() > 0) {
    summary->out() << run_summary(replay, arguments.replay, measured, limits);
    summary->close();
    std::printf("written     %s\n", summary->path().c_str());
  }
  const std::uint64_t lost = replay.statistics().lost() + (shapes ? shapes->lost() : 0);
  if (code == kDone && lost > 0) {
    std::fprintf(stderr, "acus-replay: %llu states were lost\n", static_cast<unsigned long long>(lost));
    code = kStatesLost;
  }
  if (!all_held("acus-replay", limits) && code == kDone) code = kLimitExceeded;
  return code;
}

// What was recorded of a server is simulated again: acus-export, beside this program, can. Ends as that one does.
int run_again(const CLI::App& app, const std::string& recording) {
  for (const CLI::Option* option : app.get_options()) {
    if (option->empty() || option->get_positional()) continue;
    throw std::runtime_error(option->get_name() + " means nothing for " + recording +
                             ", which is a recording and runs without a server; see acus-export --help");
  }
  const std::string program = std::filesystem::read_symlink("/proc/self/exe").parent_path() / "acus-export";
  execl(program.c_str(), program.c_str(), recording.c_str(), nullptr);
  throw std::runtime_error(recording + " is a recording, which '" + program +
                           "' runs again, but that cannot be started: " + std::strerror(errno));
}

}  // namespace

int main(int argc, char** argv) {
  std::signal(SIGXFSZ, SIG_IGN);  // a file that may not grow is an error
  std::signal(SIGPIPE, SIG_IGN);  // the files are written to their end, whoever stops reading what is printed
  CLI::App app("Drives a recorded trajectory into an acus-server and writes the forces that come back.", "acus-replay");
  Arguments arguments;
  declare(app, arguments);
  return run_program(app, argc, argv, [&] {
    arguments.replay.timeout = std::chrono::round<Timeout>(std::chrono::duration<double>(arguments.timeout_s));
    if (is_recording(arguments.trajectory)) return run_again(app, arguments.trajectory);
    return replay_trajectory(arguments);
  });
}
