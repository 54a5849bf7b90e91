// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/study/studies/haptic_run.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <deque>
#include <memory>
#include <numbers>
#include <utility>

#include "client/haptics/program/session.h"
#include "server/engine/scene/scene.h"
#include "server/engine/tick/simulation.h"
#include "tests/study/studies/haptic_hand.h"
#include "tests/study/studies/lockstep_server.h"

namespace acus {

namespace {

constexpr double kTick = 1e-3;       // s
constexpr double kGap = 2e-3;        // m, of the tip from the surface at the start
constexpr double kLongest = 8;       // s, of a run
constexpr double kPuncture = 50e-3;  // s, around a puncture

// 343 nodes and a steel needle of 1 mm, held at the bottom; nothing is told of how the base follows its commands.
std::string studied_scene(double young_modulus, HapticTask task) {
  const double punctures = task == HapticTask::palpate ? kInfinity : puncture_force(young_modulus);
  const auto number = [](double value) { return std::isinf(value) ? std::string(".inf") : std::to_string(value); };
  return R"(acus_scene: 1
name: haptics
rate: 1000
tissue:
  mesh:
    box: {size: [0.1, 0.1, 0.1], cells: [6, 6, 6]}
  regions:
    - material: {young_modulus: )" +
         number(young_modulus) + R"(, poisson_ratio: 0.45, density: 1000, rayleigh_stiffness: 0.01}
      interaction: {pressure: 5000, friction_static: 0.69, friction_dynamic: 0.6, puncture_force: )" +
         number(punctures) + ", cutting_force: " + number(puncture_force(young_modulus) / 2) + R"(}
  fixed:
    - box: {max: [.inf, .inf, -0.04]}
needles:
  - length: 0.15
    beams: 15
    base: {position: [0.003, 0.002, 0.202], orientation: [0.7071067811865476, 0, 0.7071067811865476, 0]}
)";
}

// What swings in the second half of a hold: the way of the force from one turn to the next (N), as large as it comes
// three times at least. A needle that slips once, or creeps, does not swing.
class SwingMeter {
 public:
  void add(double since, double force) {
    if (since < HandPlan::kHold / 2) return;
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
    if (since > HandPlan::kHold / 2) place += x, force += f, ++count;
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

// What one task tells, from samples of the session and steps of the device.
class Meters {
 public:
  Meters(const HapticSetting& setting, HapticOutcome& outcome)
      : setting_(setting), outcome_(outcome), chatter_(setting.rate) {}

  void step(const PlannedDevice& device) {
    made_ = device.most_made();
    const HandPlan& plan = device.plan();
    if (plan.holds()) {
      swing_.add(plan.since(), rendered_.force[0]);
      for (int i = 0; i < 2; ++i) twist_[i].add(plan.since(), rendered_.torque[i]);
    } else if (held_) {
      end_hold();
    }
    held_ = plan.holds();
  }

  void sample(const haptics::SampleRecord& sample, const PlannedDevice& device) {
    const double before = -rendered_.force[0], before_at_server = -server_.force[0];
    rendered_ = sample.rendered;
    server_ = sample.server;
    const double force = -rendered_.force[0], at_server = -server_.force[0];
    outcome_.largest_force = std::max(outcome_.largest_force, std::abs(force));
    const HandPlan& plan = device.plan();
    hold(sample, device);
    const double since = sample.time - punctured_at_;
    chatter_.add(force, plan.phase() == HandPlan::insert && outcome_.punctured && since > 0.1);
    if (setting_.turns) return;
    if (!outcome_.punctured) {
      newest_.push_back(force);
      if (static_cast<double>(newest_.size()) > kPuncture * setting_.rate + 1) newest_.pop_front();
    } else if (since < kPuncture) {
      outcome_.puncture_rise = std::max(outcome_.puncture_rise, force - outcome_.puncture_felt);
      if (before_at_server - at_server > outcome_.server_drop)
        outcome_.server_drop = before_at_server - at_server, outcome_.puncture_drop = before - force;
    }
  }

  void event(double now, const protocol::Event& event) {
    if (event.kind != protocol::EventKind::puncture || outcome_.punctured) return;
    outcome_.punctured = true;
    punctured_at_ = now;
    if (!newest_.empty()) outcome_.puncture_felt = *std::max_element(newest_.begin(), newest_.end());
  }

  void finish(double withheld) {
    if (held_) end_hold();
    if (setting_.turns) {
      outcome_.felt = secant(straight_, tilted_);
      outcome_.tissue = secant(straight_at_server_, tilted_at_server_);
      hold_of(tilted_, tilted_wanted_, tilted_at_server_);
    } else if (pressed_on_.count > 0) {
      outcome_.felt = secant(pressed_, pressed_on_);
      hold_of(pressed_on_, pressed_wanted_, pressed_at_server_);
    }
    outcome_.chatter = std::max(outcome_.chatter, chatter_.level());
    outcome_.made = std::max(outcome_.made, made_);
    outcome_.withheld += withheld;
  }

 private:
  void end_hold() {
    outcome_.swing = std::max(outcome_.swing, swing_.end());
    for (SwingMeter& each : twist_) outcome_.twist = std::max(outcome_.twist, each.end());
  }

  void hold(const haptics::SampleRecord& sample, const PlannedDevice& device) {
    const HandPlan& plan = device.plan();
    const double place = device.pose().position[0], force = -rendered_.force[0];
    const double turned = haptics::rotation_vector(device.pose().orientation)[1], torque = -rendered_.torque[1];
    if (first_) start_ = sample.base.orientation, first_ = false;
    const haptics::Vector3 base =
        start_.conjugate() * haptics::rotation_vector(sample.base.orientation * start_.conjugate());
    switch (plan.phase()) {
      case HandPlan::hold_pressed:
        return pressed_.add(plan.since(), place, force);
      case HandPlan::hold_pressed_on:
        pressed_wanted_.add(plan.since(), place, -sample.wanted.force[0]);
        pressed_at_server_.add(plan.since(), place, -server_.force[0]);
        return pressed_on_.add(plan.since(), place, force);
      case HandPlan::hold_inserted:
        straight_at_server_.add(plan.since(), base[1], -server_.torque[1]);
        return straight_.add(plan.since(), turned, torque);
      case HandPlan::hold_tilted:
        tilted_wanted_.add(plan.since(), turned, -sample.wanted.torque[1]);
        tilted_at_server_.add(plan.since(), base[1], -server_.torque[1]);
        return tilted_.add(plan.since(), turned, torque);
      default:
        return;
    }
  }

  void hold_of(const Mean& rendered, const Mean& wanted, const Mean& at_server) {
    outcome_.held = rendered.force / std::max(rendered.count, 1);
    outcome_.wanted = wanted.force / std::max(wanted.count, 1);
    outcome_.at_server = at_server.force / std::max(at_server.count, 1);
  }

  const HapticSetting& setting_;
  HapticOutcome& outcome_;
  haptics::Wrench rendered_, server_;
  haptics::Quaternion start_;
  bool first_ = true, held_ = false;
  double punctured_at_ = 0, made_ = 0;
  std::deque<double> newest_;  // N, rendered
  Mean pressed_, pressed_on_, pressed_wanted_, pressed_at_server_;
  Mean straight_, tilted_, tilted_wanted_, straight_at_server_, tilted_at_server_;
  SwingMeter swing_, twist_[2];
  ChatterMeter chatter_;
};

}  // namespace

// Forces of opening and cutting are those of a soft phantom, less for a tissue that would not bear them within a few
// millimetres; they do not grow with stiffness, nor does friction.
double puncture_force(double young_modulus) { return std::min(1.0, young_modulus / 2e4); }

haptics::DeviceProperties studied_device(const HapticSetting& setting) {
  haptics::DeviceProperties properties;
  properties.rate = setting.rate;
  properties.translation.mass = setting.mass;
  if (setting.turns) properties.rotation.largest_force = 0.3;
  return properties;
}

double felt_bound(const HapticSetting& setting, double tissue_stiffness) {
  const haptics::Coupling coupling = haptics::coupling_of(studied_device(setting));
  const double allowed = setting.turns ? coupling.rotation : coupling.translation;
  return std::min(allowed / haptics::kShare, tissue_stiffness);
}

double pressed_stiffness(double young_modulus) {
  Scene scene = parse_scene(studied_scene(young_modulus, HapticTask::palpate), "haptics");
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
    for (int i = 0; i < 8000 && since < HandPlan::kHold; ++i) {
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
void run_task(const HapticSetting& setting, HapticTask task, HapticOutcome& outcome) {
  const LockstepServer server(studied_scene(setting.young_modulus, task));
  std::atomic<bool> done = false;
  haptics::SessionOptions options;
  options.commands = server.commands();
  options.states = server.states();
  options.with_kit = setting.kit;
  options.network = setting.network;
  options.duration = kLongest;
  options.interrupt = &done;
  haptics::Session session(options);
  Meters meters(setting, outcome);
  PlannedDevice* device = nullptr;
  session.on_sample = [&](const haptics::SampleRecord& sample) {
    meters.sample(sample, *device);
    done = device->plan().phase() == HandPlan::done;
  };
  session.on_event = [&](double now, const protocol::Event& event) { meters.event(now, event); };
  session.run([&](const std::function<double()>& clock) {
    auto planned = std::make_unique<PlannedDevice>(studied_device(setting), setting.grip.hand,
                                                   HandPlan(task, kGap, puncture_force(setting.young_modulus)), clock);
    device = planned.get();
    device->on_step = [&] { meters.step(*device); };
    return planned;
  });
  meters.finish(session.results().withheld);
}

}  // namespace

HapticOutcome run_haptic(const HapticSetting& setting) {
  HapticOutcome outcome;
  if (setting.turns) {
    run_task(setting, HapticTask::turn, outcome);
  } else {
    run_task(setting, HapticTask::palpate, outcome);
    run_task(setting, HapticTask::insert, outcome);
  }
  return outcome;
}

}  // namespace acus
