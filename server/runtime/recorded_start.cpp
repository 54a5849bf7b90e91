// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/runtime/recorded_start.h"

#include <spdlog/spdlog.h>
#include <spdlog/stopwatch.h>

#include <cassert>
#include <chrono>
#include <cmath>

#include "server/engine/recording/rerun.h"

namespace acus {

namespace {

using Interrupted = std::function<bool()>;

// Where the rerun ends; then the rerun itself is not needed any more.
struct Moment {
  recorded::World world;
  State state;
};

// Of simulation time (s), for people and for --at.
double in_microseconds(double seconds) { return std::round(1e6 * seconds) / 1e6; }

// A line about once a second of work.
class RerunProgress {
 public:
  explicit RerunProgress(double seconds) : seconds_(seconds) {}

  void tell(double done) {
    if (since_told_.elapsed() < std::chrono::seconds(1)) return;
    since_told_.reset();
    spdlog::info("ran again {:.1f} of {:.1f} s", done, seconds_);
  }

 private:
  const double seconds_;
  spdlog::stopwatch since_told_;
};

void check_moment(const RecordedStart& start, const RecordingLength& length) {
  if (!length.begun) throw RecordingError("there is nothing to go on from: " + length.problem);
  const double end = in_microseconds(length.seconds);
  if (start.at && *start.at > length.seconds + length.time_step / 2)
    throw RecordingError(fmt::format("--at {}: the recording ends after {} s{}; give no more than that", *start.at, end,
                                     length.problem.empty() ? "" : ", as " + length.problem));
  if (!start.at && length.damaged)
    throw RecordingError(fmt::format("{}; --at {} goes on from the last tick before that", length.problem, end));
}

// A recording that this version cannot begin with is for another one.
Rerun begin_rerun(const RecordedStart& start, const recorded::Opening& opening) {
  try {
    return Rerun(start.recording, tell_loading);
  } catch (const std::runtime_error& error) {
    throw RecordingError(fmt::format("{}; start the version that recorded it, acus-server {} (this is {})",
                                     error.what(), opening.server, ACUS_VERSION));
  }
}

// False if it was interrupted.
bool run_again(Rerun& rerun, const RecordedStart& start, double end, const Interrupted& interrupted) {
  RerunProgress progress(start.at.value_or(end));
  const auto reached = [&] { return start.at && rerun.seconds() + rerun.simulation().model().h / 2 >= *start.at; };
  while (!reached()) {
    if (interrupted()) return false;
    if (!rerun.step()) return true;
    progress.tell(rerun.seconds());
  }
  return true;
}

void tell_outcome(const Rerun& rerun, const spdlog::stopwatch& since_start) {
  const TickReport& report = rerun.simulation().report();
  spdlog::info("ran again {} ticks, {} s, in {:.2f} s; goes on from tick {}, {} s", rerun.ticks(),
               in_microseconds(rerun.seconds()), since_start, report.tick, report.time);
  if (const std::optional<Difference>& difference = rerun.difference())
    spdlog::warn(
        "the recording comes out otherwise from tick {} of epoch {} on, as on a processor of another kind; goes on with "
        "what came out here. To go on with what was recorded, start on a machine like the one that recorded it",
        difference->tick, difference->epoch);
}

std::optional<Moment> find_moment(const RecordedStart& start, const Interrupted& interrupted) {
  const spdlog::stopwatch since_start;
  const RecordingLength length = length_of(start.recording);
  check_moment(start, length);
  spdlog::info("recorded by acus-server {}, {}: {} s", length.opening.server, length.opening.started,
               in_microseconds(length.seconds));
  Rerun rerun = begin_rerun(start, length.opening);
  if (!run_again(rerun, start, length.seconds, interrupted)) return std::nullopt;
  if (!start.at && !length.problem.empty()) spdlog::warn("the recording's end: {}", length.problem);
  tell_outcome(rerun, since_start);
  return Moment{rerun.world(), rerun.simulation().state()};
}

}  // namespace

std::unique_ptr<LoadedScene> load_recorded(const RecordedStart& start, const Interrupted& interrupted) {
  try {
    const std::optional<Moment> moment = find_moment(start, interrupted);
    if (!moment) return nullptr;
    tell_loading("the scene anew, to go on with");
    std::unique_ptr<LoadedScene> world = load_scene(moment->world);
    assert(world->simulation.model().fingerprint == moment->world.fingerprint);
    world->simulation.restore(moment->state);
    world->simulation.economize(false);
    return world;
  } catch (const RecordingError& error) {
    const std::string what = error.what();
    throw RecordingError(what.starts_with(start.recording) ? what : start.recording + ": " + what);
  }
}

}  // namespace acus
