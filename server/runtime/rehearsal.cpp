// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/runtime/rehearsal.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <span>

#include "server/engine/math/nearest_rank.h"
#include "server/engine/math/processor_time.h"
#include "server/engine/scene/text/text_table.h"

namespace acus {
namespace {

constexpr double kApproach = 0.2;    // m/s, while a needle touches nothing
constexpr double kInsertion = 0.02;  // m/s, from then on
constexpr int kWarmUp = 20;          // ticks at most that are not counted: memory is touched for the first time
constexpr int kParts = 4;            // of the way in
constexpr int kLeastTicks = 20;      // of a part, unless it is the only one

struct Tick {
  double seconds = 0;  // processor time
  double depth = 0;    // m
  double rows = 0;
  double window = 0;  // s, of the window's thread
  bool outside = true;
};

template <class Of>
double quantile_of(std::span<const Tick> ticks, double q, Of&& of) {
  std::vector<double> values;
  for (const Tick& tick : ticks) values.push_back(of(tick));
  return nearest_rank(values, q);
}

RehearsedTicks sum_up(std::span<const Tick> ticks) {
  if (ticks.empty()) return {};
  const auto seconds = [](const Tick& tick) { return tick.seconds; };
  return {static_cast<int>(ticks.size()), quantile_of(ticks, 0.5, [](const Tick& tick) { return tick.depth; }),
          quantile_of(ticks, 0.5, [](const Tick& tick) { return tick.rows; }), quantile_of(ticks, 0.5, seconds),
          quantile_of(ticks, 0.99, seconds)};
}

// How far a needle's base goes along a straight line until no part of the needle can touch the tissue any more (m):
// none is farther from the base than the needle is long.
double way_past_tissue(const Simulation& simulation, const Needle& needle) {
  const Eigen::Ref<const Matrix3X> nodes = simulation.tissue_positions();
  const double farthest = nodes.cols() == 0 ? 0 : (nodes.colwise() - needle.base.position).colwise().norm().maxCoeff();
  return farthest + needle.length;
}

// Pushes every needle along its axis, until it has gone its length beyond where it touched the tissue, or has missed
// it.
class Insertion {
 public:
  explicit Insertion(Simulation& simulation)
      : simulation_(simulation), time_step_(1 / simulation.scene().rate), ways_(simulation.scene().needles.size()) {
    for (std::size_t i = 0; i < ways_.size(); ++i)
      ways_[i].past = way_past_tissue(simulation, simulation.scene().needles[i]);
  }

  // False when every needle is where it shall go.
  bool command(std::uint64_t seq) {
    bool moving = false;
    for (std::size_t i = 0; i < ways_.size(); ++i) moving = command(i, seq) || moving;
    return moving;
  }

  Tick timed_tick() {
    Tick tick{.seconds = processor_time_of([&] { simulation_.step(); })};
    tick.rows = static_cast<double>(simulation_.report().rows);
    tick.window = simulation_.window_seconds();
    for (const NeedleReport& needle : simulation_.report().needles) {
      tick.depth = std::max(tick.depth, needle.inserted_depth);
      tick.outside = tick.outside && needle.phase == Phase::free;
    }
    return tick;
  }

 private:
  struct Way {
    double gone = 0, inside = 0;  // m, commanded
    double past = 0;              // m, way_past_tissue()
    bool touched = false;
  };

  // How far the base has come (m): less than commanded if the scene's max_speed is less than ours.
  double gone(std::size_t i) const {
    const int needle = static_cast<int>(i);
    return (simulation_.needle_positions(needle).col(0) - simulation_.scene().needles[i].base.position).norm();
  }

  bool command(std::size_t i, std::uint64_t seq) {
    const Needle& needle = simulation_.scene().needles[i];
    Way& way = ways_[i];
    way.touched = way.touched || simulation_.report().needles[i].phase != Phase::free;
    if (way.inside > needle.length || (!way.touched && gone(i) > way.past)) return false;
    const double step = time_step_ * (way.touched ? kInsertion : kApproach);
    way.gone += step;
    way.inside += way.touched ? step : 0;
    Command command;
    command.seq = seq;
    Pose pose = needle.base;
    pose.position += way.gone * (pose.orientation * Vector3::UnitX());
    command.pose = pose;
    simulation_.command(static_cast<int>(i), command);
    return true;
  }

  Simulation& simulation_;
  double time_step_;
  std::vector<Way> ways_;
};

// Fills `ticks`, and says why there are no more of them.
RehearsalEnd run(Simulation& simulation, const RehearsalLimits& limits, std::vector<Tick>& ticks) {
  Insertion insertion(simulation);
  const auto most = static_cast<std::size_t>(std::ceil(limits.duration * simulation.scene().rate));
  for (double spent = 0; insertion.command(ticks.size() + 1); spent += ticks.back().seconds) {
    if (spent >= limits.processor_time) return RehearsalEnd::processor_time;
    if (ticks.size() >= most) return RehearsalEnd::duration;
    ticks.push_back(insertion.timed_tick());
  }
  return RehearsalEnd::needles_are_through;
}

// At least half of few ticks are counted.
void leave_out_warm_up(std::vector<Tick>& ticks) {
  ticks.erase(ticks.begin(), ticks.begin() + std::min<std::ptrdiff_t>(kWarmUp, std::ssize(ticks) / 2));
}

int parts_of(std::ptrdiff_t ticks) {
  if (ticks == 0) return 0;
  return static_cast<int>(std::clamp<std::ptrdiff_t>(ticks / kLeastTicks, 1, kParts));
}

std::string number(const char* format, double value) {
  char text[32];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

void add(TextTable& table, const std::string& name, const RehearsedTicks& part, double time_step) {
  if (part.ticks == 0) return;
  table.add({"  " + name, number("%.0f", 1e3 * part.depth), number("%.0f", part.rows),
             number("%.3f", 1e3 * part.median), number("%.3f", 1e3 * part.p99),
             number("%.0f %%", 100 * part.p99 / time_step)});
}

std::string why_none_is_inside(const Rehearsal& rehearsal) {
  const std::string not_reached = "  the tissue is not reached within ";
  switch (rehearsal.end) {
    case RehearsalEnd::needles_are_through:
      return "  no needle gets to the tissue along its own axis";
    case RehearsalEnd::processor_time:
      return not_reached + number("%g", rehearsal.limits.processor_time) + " s of processor time";
    case RehearsalEnd::duration:
      return not_reached + number("%g", rehearsal.limits.duration) + " s of simulation time";
  }
  return {};
}

}  // namespace

Rehearsal rehearse(Simulation& simulation, const RehearsalLimits& limits) {
  simulation.reset();
  std::vector<Tick> ticks;
  const RehearsalEnd end = run(simulation, limits, ticks);
  simulation.reset();
  leave_out_warm_up(ticks);
  const double window_seconds =
      ticks.empty() ? 0 : quantile_of(ticks, 0.99, [](const Tick& tick) { return tick.window; });
  const auto inside = std::stable_partition(ticks.begin(), ticks.end(), [](const Tick& tick) { return tick.outside; });
  const int window = simulation.scene().tissue.window_thread ? simulation.scene().tissue.window : 0;
  Rehearsal rehearsal{sum_up({ticks.begin(), inside}), {}, end, limits, window, window_seconds};
  const std::ptrdiff_t count = ticks.end() - inside;
  const int parts = parts_of(count);
  for (int part = 0; part < parts; ++part)
    rehearsal.inside.push_back(sum_up({inside + count * part / parts, inside + count * (part + 1) / parts}));
  return rehearsal;
}

int window_to_try(const Simulation& simulation) {
  constexpr double kUnnoticed = 16e-3;  // s
  constexpr int kLeastNodes = 700;      // whose elements and substitutions take longer than all else
  if (simulation.scene().tissue.window > 0 || simulation.costs().free_nodes < kLeastNodes) return 0;
  Scene scene = simulation.scene();
  scene.tissue.window = static_cast<int>(std::round(kUnnoticed * scene.rate));
  if (scene.tissue.fixed.empty() || scene.tissue.window < 2) return 0;
  try {
    validate(scene);
  } catch (const SceneError&) {
    return 0;
  }
  return scene.tissue.window;
}

std::vector<SceneWarning> rehearsal_warnings(const Rehearsal& rehearsal, double time_step, int window) {
  constexpr double kSpare = 1.25;  // of the time that a tick takes
  std::vector<SceneWarning> warnings;
  double longest = rehearsal.outside.p99;
  for (const RehearsedTicks& part : rehearsal.inside) longest = std::max(longest, part.p99);
  if (longest > time_step)
    warnings.push_back(
        {"ticks", "they take up to " + number("%.0f %%", 100 * longest / time_step) +
                      " of their time, so that this machine does not hold the rate; take a rate of at most " +
                      number("%.0f", 1 / (kSpare * longest)) + " Hz, fewer cells or beams, " +
                      (window > 0 ? "tissue.window: " + std::to_string(window) + ", " : "") + "or --lockstep"});
  if (const double needed = kSpare * rehearsal.window_seconds; needed > rehearsal.window * time_step)
    warnings.push_back({"tissue.window", "its thread takes up to " + number("%.1f ms", 1e3 * rehearsal.window_seconds) +
                                             " of the " + number("%.1f ms", 1e3 * rehearsal.window * time_step) +
                                             " of a window, so that ticks wait for it; take at least " +
                                             number("%.0f", std::ceil(needed / time_step)) + ", or fewer cells"});
  return warnings;
}

std::string describe(const Rehearsal& rehearsal, double time_step) {
  TextTable table;
  table.add({"ticks on this machine", "depth (mm)", "rows", "p50 (ms)", "p99 (ms)", "p99 of a tick's time"});
  add(table, "needles outside", rehearsal.outside, time_step);
  for (const RehearsedTicks& part : rehearsal.inside) add(table, "pushed in", part, time_step);
  if (rehearsal.inside.empty()) table.add({why_none_is_inside(rehearsal)});
  if (rehearsal.window > 0)
    table.add({"  the window's thread takes " + number("%.2f", 1e3 * rehearsal.window_seconds) + " ms of a window of " +
               number("%.2f", 1e3 * rehearsal.window * time_step) + " ms"});
  return table.text();
}

}  // namespace acus
