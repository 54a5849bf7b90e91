// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/study/studies/haptic_run.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "client/haptics/kit.h"
#include "client/haptics/simulated_handle.h"
#include "tests/study/studies/local_model_of.h"

namespace acus {

namespace {

constexpr double kTick = 1e-3;  // s
constexpr double kGap = 2e-3;   // m, of the tip from the surface at the start
constexpr double kStep = haptics::SimulatedHandle::kStep;

// Forces of opening and cutting are those of a soft phantom, less for a tissue that would not bear them within a few
// millimetres; they do not grow with stiffness, nor does friction.
double puncture_force(double young_modulus) { return std::min(1.0, young_modulus / 2e4); }

// What the hand does in one run: it presses a tissue that never opens twice, or inserts the needle and pulls it back.
enum class Task { palpate, insert };

// 343 nodes and a steel needle of 1 mm, held at the bottom.
Scene studied_scene(double young_modulus, Task task) {
  Scene scene = parse_scene(R"(acus_scene: 1
rate: 1000
tissue:
  mesh:
    box: {size: [0.1, 0.1, 0.1], cells: [6, 6, 6]}
  regions:
    - material: {poisson_ratio: 0.45, density: 1000, rayleigh_stiffness: 0.01}
      interaction: {pressure: 5000, friction_static: 0.69, friction_dynamic: 0.6}
  fixed:
    - box: {max: [.inf, .inf, -0.04]}
needles:
  - length: 0.15
    beams: 15
    base: {position: [0.003, 0.002, 0.202], orientation: [0.7071067811865476, 0, 0.7071067811865476, 0]}
)",
                            "haptics");
  Region& region = scene.tissue.regions[0];
  region.material.young_modulus = young_modulus;
  region.interaction.puncture_force = task == Task::palpate ? kInfinity : puncture_force(young_modulus);
  region.interaction.cutting_force = puncture_force(young_modulus) / 2;
  return scene;
}

// Where the hand means to be: phases, each of which ends when its condition holds.
class Plan {
 public:
  enum Phase {
    approach,
    press,
    hold_pressed,
    press_on,
    hold_pressed_on,
    insert,
    hold_inserted,
    pull,
    hold_pulled,
    done
  };

  Plan(Task task, double puncture_force) : task_(task), puncture_force_(puncture_force) {}

  // One step later, with the force against the hand and the place of the handle (N, m).
  void step(double h, double force, double place) {
    since_ += h;
    meant_ += h * speed();
    if (ended(force, place)) {
      phase_ = next();
      since_ = 0;
      began_at_ = meant_;
    }
  }

  Phase phase() const { return phase_; }
  double since() const { return since_; }
  double meant() const { return meant_; }  // m
  double speed() const {                   // m/s
    switch (phase_) {
      case approach:
      case insert:
        return 0.05;
      case press:
      case press_on:
        return 0.02;
      case pull:
        return -0.05;
      default:
        return 0;
    }
  }
  bool holds() const { return speed() == 0 && phase_ != done; }

  static constexpr double kHold = 0.6;  // s

 private:
  Phase next() const {
    if (phase_ == approach && task_ == Task::insert) return insert;
    if (phase_ == hold_pressed_on) return done;
    return static_cast<Phase>(phase_ + 1);
  }
  bool ended(double force, double place) const {
    switch (phase_) {
      case approach:
        return meant_ > kGap - 0.5e-3;
      case press:
        return force > 0.2 * puncture_force_ || meant_ > kGap + 0.03;
      case press_on:
        return meant_ > began_at_ + 2e-3 && (force > 0.6 * puncture_force_ || meant_ > kGap + 0.06);
      case insert:
        return place > kGap + 0.02 || meant_ > kGap + 0.06;
      case pull:
        return meant_ < began_at_ - 8e-3;
      default:
        return since_ > kHold;
    }
  }

  Task task_;
  double puncture_force_;
  Phase phase_ = approach;
  double since_ = 0, meant_ = 0, began_at_ = 0;
};

// What swings in the second half of a hold: the way of the force from one turn to the next (N), as large as it comes
// three times at least. A needle that slips once, or creeps, does not swing.
class SwingMeter {
 public:
  void add(double since, double force) {
    if (since < Plan::kHold / 2) return;
    if (count_++ == 0) turn_ = extreme_ = force;
    if ((force - extreme_) * (extreme_ - turn_) >= 0) {
      extreme_ = force;
    } else if (std::abs(force - extreme_) > kTurn) {
      note(std::abs(extreme_ - turn_));
      turn_ = extreme_;
      extreme_ = force;
    }
  }
  double end() {
    note(std::abs(extreme_ - turn_));
    const double third = ways_[2];
    *this = {};
    return third;
  }

 private:
  static constexpr double kTurn = 5e-3;  // N, back by so much makes a turn

  void note(double way) {
    for (double& each : ways_)
      if (way > each) std::swap(way, each);
  }

  int count_ = 0;
  double turn_ = 0, extreme_ = 0;
  double ways_[3] = {};  // the largest first
};

// Of the second half of a hold.
struct Mean {
  double place = 0, force = 0;  // m, N, sums
  int count = 0;

  void add(double since, double x, double f) {
    if (since > Plan::kHold / 2) place += x, force += f, ++count;
  }
};

// Force over way from one hold to the next; NaN where there is no way.
double secant(const Mean& low, const Mean& high) {
  const double way = high.place / high.count - low.place / low.count;
  return std::abs(way) > 1e-7 ? (high.force / high.count - low.force / low.count) / way : NAN;
}

// Two high passes of first order at 30 Hz, one after the other.
class ChatterMeter {
 public:
  explicit ChatterMeter(double rate) : keep_(1 / (1 + 2 * std::numbers::pi * 30 / rate)) {}

  void add(double force, bool counts) {
    const double once = keep_ * (once_ + force - force_);
    const double twice = keep_ * (twice_ + once - once_);
    force_ = force, once_ = once, twice_ = twice;
    if (counts) squares_ += twice * twice, ++count_;
  }
  double level() const { return count_ > 0 ? std::sqrt(squares_ / count_) : 0; }

 private:
  double keep_, force_ = 0, once_ = 0, twice_ = 0, squares_ = 0;
  int count_ = 0;
};

haptics::Vector3 plain(const Vector3& v) { return {{v.x(), v.y(), v.z()}}; }

haptics::Pose plain(const Pose& pose) {
  const Quaternion& q = pose.orientation;
  return {plain(pose.position), {q.w(), q.x(), q.y(), q.z()}};
}

Pose of_server(const haptics::Pose& pose) {
  const auto& [p, q] = pose;
  return {Vector3(p[0], p[1], p[2]), Quaternion(q.w, q.x, q.y, q.z)};
}

struct CommandSent {
  haptics::Pose base;
  std::uint64_t seq = 0;
};

// What comes from the server: the local model, the force with the needle's inertia, and whether the needle is inside.
struct ModelSent {
  haptics::LocalModel model;
  haptics::Wrench force;
  bool inserted = false;
};

// The server's side of the loop: takes commands, makes ticks, sends what they tell.
class ServerSide {
 public:
  ServerSide(const HapticSetting& setting, Task task)
      : simulation_(studied_scene(setting.young_modulus, task)),
        up_({setting.delay / 2, 0, 1}),
        down_({setting.delay / 2, 0, 2}),
        in_use_{start(), 0} {}

  haptics::Pose start() const { return plain(simulation_.scene().needles[0].base); }
  void send(double now, const CommandSent& command) { up_.send(now, command); }
  std::optional<ModelSent> receive(double now) { return down_.receive(now); }

  void tick(double now) {
    while (const auto command = up_.receive(now)) in_use_ = *command;
    const haptics::LocalModel model = step_with_local_model(simulation_, of_server(in_use_.base), in_use_.seq);
    const NeedleReport& needle = simulation_.report().needles[0];
    down_.send(now, {model, {plain(needle.base_force), plain(needle.base_torque)}, needle.phase == Phase::inside});
  }

 private:
  Simulation simulation_;
  haptics::DelayLine<CommandSent> up_;
  haptics::DelayLine<ModelSent> down_;
  CommandSent in_use_;
};

// The device's side: a sample of it, with the kit or without.
class DeviceSide {
 public:
  DeviceSide(const HapticSetting& setting, const haptics::Pose& base, HapticOutcome& outcome)
      : with_kit_(setting.kit),
        handle_({studied_device(setting.rate).translation, {0, 0, 3}, setting.grip.hand}),
        kit_(studied_device(setting.rate), options(base)),
        registration_(options(base).workspace),
        chatter_(setting.rate),
        outcome_(outcome) {
    kit_.begin({}, base);
    registration_.bring_together({}, base);
  }

  // The handle's axis is the needle's.
  static haptics::KitOptions options(const haptics::Pose& base) {
    haptics::KitOptions options;
    options.workspace.world_from_device = base.orientation;
    return options;
  }

  void sample(double now, const Plan& plan, ServerSide& server) {
    const double before = force_, before_from_server = from_server();
    while (const auto sent = server.receive(now)) {
      kit_.take(sent->model);
      newest_ = with_kit_ ? sent->model.felt : sent->force;
      if (sent->inserted && !outcome_.punctured) outcome_.punctured = true, punctured_at_ = now;
    }
    const haptics::Pose device{handle_.measured(), {}};
    const haptics::Kit::Answer answer = kit_.step({device, false});
    const haptics::Wrench wrench = with_kit_ ? answer.on_hand : registration_.at_device(newest_);
    handle_.write(wrench.force);
    force_ = wrench.force[0];
    server.send(now, {with_kit_ ? answer.base : registration_.base_of(device), answer.seq});
    const double drop = from_server() - before_from_server;
    if (outcome_.punctured && now - punctured_at_ < kPuncture && drop > outcome_.server_drop)
      outcome_.server_drop = drop, outcome_.puncture_drop = force_ - before;
    measure(now, plan);
  }

  haptics::SimulatedHandle& handle() { return handle_; }
  double force() const { return force_; }  // N, along the needle

  void finish() {
    if (pressed_on_.count > 0) outcome_.felt = secant(pressed_, pressed_on_);
    outcome_.chatter = std::max(outcome_.chatter, chatter_.level());
    outcome_.made = std::max(outcome_.made, handle_.most_made());
    if (with_kit_) outcome_.withheld += kit_.passivity().withheld();
  }

 private:
  double from_server() const { return registration_.at_device(newest_).force[0]; }

  void measure(double now, const Plan& plan) {
    outcome_.largest_force = std::max(outcome_.largest_force, std::abs(force_));
    if (plan.phase() == Plan::hold_pressed) pressed_.add(plan.since(), handle_.position()[0], -force_);
    if (plan.phase() == Plan::hold_pressed_on) pressed_on_.add(plan.since(), handle_.position()[0], -force_);
    chatter_.add(force_, plan.phase() == Plan::insert && outcome_.punctured && now - punctured_at_ > 0.1);
  }

  static constexpr double kPuncture = 0.02;  // s, in which the force of a puncture falls

  bool with_kit_;
  haptics::SimulatedHandle handle_;
  haptics::Kit kit_;
  haptics::Registration registration_;
  haptics::Wrench newest_;  // of the server, as this loop uses it
  double force_ = 0, punctured_at_ = 0;
  Mean pressed_, pressed_on_;
  ChatterMeter chatter_;
  HapticOutcome& outcome_;
};

constexpr double kLongest = 8;  // s, of a run

}  // namespace

haptics::DeviceProperties studied_device(double rate) {
  haptics::DeviceProperties properties;
  properties.rate = rate;
  return properties;
}

double felt_bound(const HapticSetting& setting, double tissue_stiffness) {
  const double damping = studied_device(setting.rate).translation.damping;
  return std::min(haptics::passive_stiffness(damping, 1 / setting.rate, setting.delay), tissue_stiffness);
}

double pressed_stiffness(double young_modulus) {
  Scene scene = studied_scene(young_modulus, Task::palpate);
  scene.needles[0].smoothing = 0;
  Simulation simulation(scene);
  Pose base = scene.needles[0].base;
  const double start = base.position.z(), force = puncture_force(young_modulus);
  // From just before the surface, in steps that even a rigid tissue under the needle's own stiffness of 1e6 N/m answers
  // with a small part of the force.
  const double stride = std::clamp(0.02 * force / young_modulus * 30, 1e-8, 2e-5);
  Mean holds[2];
  double way = kGap - 1e-6;
  std::uint64_t seq = 0;
  for (Mean& hold : holds) {
    const double enough = (&hold == holds ? 0.2 : 0.6) * force;
    double since = 0;
    for (int i = 0; i < 8000 && since < Plan::kHold; ++i) {
      base.position.z() = start - way;
      simulation.command(0, {++seq, base, std::nullopt});
      simulation.step();
      const NeedleReport& needle = simulation.report().needles[0];
      if (since > 0 || needle.base_force.z() > enough)
        since += kTick;
      else
        way += stride;
      hold.add(since, start - needle.base.position.z(), needle.base_force.z());
    }
  }
  return secant(holds[0], holds[1]);
}

namespace {

// One task, with what it tells added to the outcome.
void run_task(const HapticSetting& setting, Task task, HapticOutcome& outcome) {
  ServerSide server(setting, task);
  DeviceSide device(setting, server.start(), outcome);
  Plan plan(task, puncture_force(setting.young_modulus));
  SwingMeter swing;
  const long steps_per_tick = std::lround(kTick / kStep);
  const long steps_per_sample = std::lround(1 / (setting.rate * kStep));
  for (long i = 0; static_cast<double>(i) * kStep < kLongest && plan.phase() != Plan::done; ++i) {
    const double now = static_cast<double>(i) * kStep;
    if (i % steps_per_tick == 0) server.tick(now);
    if (i % steps_per_sample == 0) device.sample(now, plan, server);
    device.handle().mean({{plan.meant(), 0, 0}}, {{plan.speed(), 0, 0}});
    device.handle().advance(kStep);
    const bool held = plan.holds();
    if (held) swing.add(plan.since(), device.handle().acting()[0]);
    plan.step(kStep, -device.force(), device.handle().position()[0]);
    if (held && !plan.holds()) outcome.swing = std::max(outcome.swing, swing.end());
  }
  device.finish();
}

}  // namespace

HapticOutcome run_haptic(const HapticSetting& setting) {
  HapticOutcome outcome;
  run_task(setting, Task::palpate, outcome);
  run_task(setting, Task::insert, outcome);
  return outcome;
}

}  // namespace acus
