// SPDX-License-Identifier: MIT
#include "client/replay/replay.h"

#include <time.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <exception>
#include <thread>
#include <variant>

namespace acus::client {
namespace {

constexpr Timeout kSlice{50};             // between looks at the interrupt flag while nothing arrives
constexpr double kMaxPoses = 100e6;       // of one needle in a run
constexpr int kTransits = 15;             // measured, of which the median counts
constexpr Timeout kTransitPause{3};       // between two of them
constexpr double kSettling = 0.1;         // s of states from which the server's beat is told, ...
constexpr double kLongestSettling = 0.2;  // s of waiting for them: a server that is too slow for its rate has fewer

// Of a tick, that a pose is to arrive before the tick begins: room for poses and ticks that are not quite punctual.
constexpr double kLead = 0.25;

template <class Info>
bool has(const std::vector<Info>& infos, const std::string& name) {
  return std::any_of(infos.begin(), infos.end(), [&](const Info& info) { return info.name == name; });
}

std::string names_of(const protocol::HelloReply& server) {
  std::string names;
  for (const auto& needle : server.needles) names += (names.empty() ? "'" : ", '") + needle.name + "'";
  for (const auto& guide : server.guides) names += ", '" + guide.name + "'";
  return names;
}

bool spins(const Motion& motion) {
  return std::any_of(motion.samples.begin(), motion.samples.end(),
                     [](const Sample& sample) { return sample.pose.spin.value_or(0) != 0; });
}

void check_bodies(const Trajectory& trajectory, const protocol::HelloReply& server) {
  for (const Motion& motion : trajectory.motions) {
    const bool guide = has(server.guides, motion.needle);
    if (!guide && !has(server.needles, motion.needle)) {
      throw Unsuitable("the trajectory moves needle '" + motion.needle + "', but scene '" + server.scene + "' has " +
                       names_of(server));
    }
    if (guide && spins(motion)) {
      throw Unsuitable("the trajectory spins '" + motion.needle + "', which is a guide; its spin must be 0");
    }
  }
}

void check_clock_mode(bool lockstep, const protocol::HelloReply& server) {
  if (lockstep == server.lockstep) return;
  throw Unsuitable(server.lockstep ? "the server runs in lockstep; replay with --lockstep or start it without"
                                   : "the server runs in real time; replay without --lockstep or start it with");
}

std::chrono::steady_clock::duration to_clock(double seconds) {
  return std::chrono::duration_cast<std::chrono::steady_clock::duration>(std::chrono::duration<double>(seconds));
}

// That cover the duration (s) at a rate (Hz), rounding errors aside.
std::uint64_t periods_in(double duration, double rate) {
  return static_cast<std::uint64_t>(std::ceil(duration * rate * (1 - 1e-12)));
}

// Unlike std::this_thread::sleep_until, which asks for what is left and so is late by what happens after it looked at
// the clock.
void sleep_until(std::chrono::steady_clock::time_point time) {
  const auto since_boot = time.time_since_epoch();
  const auto seconds = std::chrono::floor<std::chrono::seconds>(since_boot);
  const timespec deadline{seconds.count(), std::chrono::nanoseconds(since_boot - seconds).count()};
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &deadline, nullptr) == EINTR) {
  }
}

}  // namespace

Replay::Replay(const Trajectory& trajectory, const ReplayOptions& options, RunLog* log, ShapeLog* shapes)
    : trajectory_(trajectory),
      options_(options),
      log_(log),
      shapes_(shapes),
      commands_(options.commands, options.keys),
      states_(options.states, StateLink::kCapacity, options.keys),
      sent_time_(trajectory.begin()) {}

void Replay::run() {
  greet();
  subscribe();
  await_first_states();
  if (options_.lockstep) {
    run_in_lockstep();
  } else {
    run_in_real_time();
    await_last_states();
  }
  if (options_.shutdown) commands_.shutdown(options_.timeout);
}

void Replay::greet() {
  server_ = commands_.hello(options_.timeout);
  if (!(server_.rate > 0))
    throw ProtocolMismatch("the server states a rate of " + std::to_string(server_.rate) + " Hz");
  check_bodies(trajectory_, server_);
  check_clock_mode(options_.lockstep, server_);
  if (duration() * rate() > kMaxPoses) throw Unsuitable("the trajectory is too long for this rate of poses");
  if (shapes_) shapes_->begin(server_, commands_.describe(options_.timeout));
  std::vector<std::string> driven;
  for (const Motion& motion : trajectory_.motions) driven.push_back(motion.needle);
  commands_.acquire(driven, options_.timeout);
  if (server_.paused) commands_.resume(options_.timeout);
  if (!options_.lockstep) measure_transit();
}

// By questions that are far enough apart for all threads on the way to fall asleep, as they do between poses.
void Replay::measure_transit() {
  std::vector<double> transits;
  for (int i = 0; i < kTransits; ++i) {
    std::this_thread::sleep_for(kTransitPause);
    const double asked = now();
    commands_.hello(options_.timeout);
    transits.push_back(now() - asked);
  }
  transit_ = distribution_of(transits).p50;
}

// A `stats` message that arrives proves that the server knows of the subscriptions before it, so that no state can be
// missed from then on.
void Replay::subscribe() {
  if (shapes_) {
    for (const char* topic : {"needle", "tissue"}) states_.subscribe(topic);
  }
  for (const char* topic : {"force", "event", "stats"}) states_.subscribe(topic);
  receive_until([this] { return statistics_.stats_received() > 0; }, Patience::in_all, "statistics");
}

// The run begins with a state from before the first pose, so that the numbers of its poses follow those of whoever
// drove the needles last.
void Replay::await_first_states() {
  if (options_.lockstep) {
    step();
  } else {
    const auto enough = static_cast<std::uint64_t>(std::ceil(kSettling * server_.rate));
    const double latest = now() + kLongestSettling;
    const auto settled = [&] { return statistics_.states() >= enough || now() >= latest; };
    receive_until([&] { return all_needles_seen() && settled(); }, Patience::in_all, "the first force states");
  }
  for (const auto& [name, run] : statistics_.needles()) first_seq_ = std::max(first_seq_, run.last_seq + 1);
}

void Replay::run_in_real_time() {
  statistics_.reserve(trajectory_.motions.size() * (periods_in(duration(), rate()) + 1));
  const auto begin = first_departure();
  std::exception_ptr failure;
  std::atomic<bool> ended = false;
  std::atomic<bool> stop = false;
  std::jthread sender([&] {
    try {
      send_poses_on_time(begin, stop);
    } catch (...) {
      failure = std::current_exception();
    }
    ended = true;
  });
  try {
    receive_until([&] { return ended.load(); }, Patience::per_state, "force states");
  } catch (...) {
    stop = true;
    throw;
  }
  sender.join();
  if (failure) std::rethrow_exception(failure);
}

// Both sides keep the same rate on the same clock, if they run on one machine. A state comes in one tick's work and
// half a transit after its tick was due, a pose arrives half a transit after it left.
Replay::Clock::time_point Replay::first_departure() const {
  const double period = 1 / server_.rate;
  const double due = statistics_.typical_arrival(period) - statistics_.punctuality().end_p50 - 0.5 * transit_;
  const double departure = due - 0.5 * transit_ - kLead * period;
  return start_ + to_clock(departure + period * (std::ceil((now() - departure) / period) + 1));
}

// Forth, back and forth again, so that passes join without a jump.
double Replay::trajectory_time(double elapsed) const {
  const double pass = std::min(std::floor(elapsed / pass_duration()), options_.passes - 1.0);
  if (!(pass > 0)) return trajectory_.begin() + elapsed;
  const double within = elapsed - pass * pass_duration();
  return std::fmod(pass, 2) > 0 ? trajectory_.end() - within : trajectory_.begin() + within;
}

void Replay::send_poses_on_time(Clock::time_point begin, const std::atomic<bool>& stop) {
  const std::uint64_t count = periods_in(duration(), rate());
  const auto deadline = [&](std::uint64_t k) { return begin + to_clock(static_cast<double>(k) / rate()); };
  sent_at_.reserve(count + 1);
  for (std::uint64_t k = 0; k <= count && !stop; ++k) {
    if (k < count && Clock::now() >= deadline(k + 1)) {
      ++deadlines_missed_;
      continue;
    }
    sleep_until(deadline(k));
    send_poses(trajectory_time(static_cast<double>(k) / rate()));
  }
}

void Replay::run_in_lockstep() {
  const std::uint64_t ticks = periods_in(duration(), server_.rate) + 1;
  const double poses_per_tick = std::min(rate() / server_.rate, 1.0);
  double poses_due = 1;
  for (std::uint64_t tick = 0; tick < ticks; ++tick, poses_due += poses_per_tick) {
    if (poses_due >= 1) {
      send_poses(trajectory_time(static_cast<double>(tick) / server_.rate));
      poses_due -= 1;
    }
    step();
  }
}

void Replay::send_poses(double time) {
  const std::uint64_t seq = first_seq_ + sent_at_.size();
  sent_at_.push_back(now());
  sent_time_ = time;
  for (const Motion& motion : trajectory_.motions) {
    auto pose = pose_at(motion, time);
    pose.seq = seq;
    pose.time = options_.lockstep ? time : sent_at_.back();  // states repeat it: the same in every run
    if (!commands_.send(pose)) throw Vanished("the server at '" + options_.commands + "' takes no more poses");
  }
  if (const auto rejection = commands_.next_rejection()) throw Refused(*rejection);
}

void Replay::step() {
  const auto done = commands_.step(1, options_.timeout);
  const auto complete = [&] { return all_needles_at(done.tick) && (!shapes_ || shapes_->complete_at(done.tick)); };
  receive_until(complete, Patience::in_all, "the states of tick " + std::to_string(done.tick));
}

// The last pose must have been felt, and one more `stats` tells how the server fared until then.
void Replay::await_last_states() {
  const auto stats = statistics_.stats_received();
  receive_until([&] { return last_poses_used() && statistics_.stats_received() > stats; }, Patience::in_all,
                "a force state that used the last pose, and the statistics after it");
}

template <class Done>
void Replay::receive_until(Done done, Patience patience, const std::string& awaited) {
  auto deadline = Clock::now() + options_.timeout;
  while (!done()) {
    if (options_.interrupt && *options_.interrupt) throw Interrupted("interrupted");
    const bool received = receive(kSlice);
    if (received && patience == Patience::per_state) deadline = Clock::now() + options_.timeout;
    if (patience == Patience::in_all) check_commands(received, awaited);
    if (Clock::now() < deadline) continue;
    throw Vanished("waited " + std::to_string(options_.timeout.count()) + " ms in vain for " + awaited + " from '" +
                   options_.states + "'");
  }
}

// What the server thinks of the poses, and whether it is still there once its states have run dry.
void Replay::check_commands(bool receiving, const std::string& awaited) {
  if (const auto rejection = commands_.next_rejection()) throw Refused(*rejection);
  if (receiving || commands_.connected()) return;
  throw Vanished("the server at '" + options_.commands + "' ended before " + awaited + " came");
}

bool Replay::receive(Timeout timeout) {
  const auto state = states_.receive(timeout);
  if (state) take(*state);
  return state.has_value();
}

void Replay::take(const protocol::State& state) {
  const double received = now();
  if (const auto* force = std::get_if<protocol::Force>(&state)) {
    statistics_.take(*force, received);
    if (log_) log_->write(*force, received);
    if (options_.on_state) options_.on_state(*force);
  } else if (const auto* event = std::get_if<protocol::Event>(&state)) {
    statistics_.take(*event);
    if (log_) log_->write(*event);
  } else if (const auto* stats = std::get_if<protocol::Stats>(&state)) {
    statistics_.take(*stats);
    if (options_.on_stats) options_.on_stats(*stats, received);
  } else if (const auto* needle = std::get_if<protocol::NeedleShape>(&state)) {
    record(*needle);
  } else if (const auto* tissue = std::get_if<protocol::TissueShape>(&state)) {
    record(*tissue);
  }
}

void Replay::record(const protocol::NeedleShape& shape) {
  if (shapes_) shapes_->write(shape);
}

// States do not tell where the guides are, so what they were commanded to does.
void Replay::record(const protocol::TissueShape& shape) {
  if (!shapes_) return;
  for (const Motion& motion : trajectory_.motions) {
    if (is_guide(motion)) shapes_->write(pose_at(motion, sent_time_));
  }
  shapes_->write(shape);
}

protocol::Pose Replay::pose_at(const Motion& motion, double time) const {
  const BasePose pose = motion.at(time);
  const auto& q = pose.orientation;
  protocol::Pose message;
  message.needle = motion.needle;
  message.position = pose.position;
  message.orientation = {q[0], q[1], q[2], q[3]};
  if (!is_guide(motion)) message.spin = pose.spin;
  return message;
}

bool Replay::is_guide(const Motion& motion) const { return has(server_.guides, motion.needle); }

bool Replay::all_needles_at(std::uint64_t tick) const {
  const auto& needles = statistics_.needles();
  return all_needles_seen() &&
         std::all_of(needles.begin(), needles.end(), [&](const auto& entry) { return entry.second.last_tick == tick; });
}

bool Replay::last_poses_used() const {
  const std::uint64_t last_seq = first_seq_ + sent_at_.size() - 1;
  return std::all_of(trajectory_.motions.begin(), trajectory_.motions.end(), [&](const Motion& motion) {
    return is_guide(motion) || statistics_.needles().at(motion.needle).last_seq == last_seq;
  });
}

double Replay::now() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }

}  // namespace acus::client
