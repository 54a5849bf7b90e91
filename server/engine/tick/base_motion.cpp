// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/tick/base_motion.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "server/engine/math/rotation.h"

namespace acus {

namespace {

constexpr double kMaxTurn = 3;           // rad of spin in a tick: less than half a turn, or nobody could tell which way

constexpr double kMemory = 16;  // commands that the rhythm is a mean of

// Of a quaternion's squared length, half of what rotation_log() bears. Whoever takes less exact ones from outside divides
// them by their length (protocol/unit_quaternion.h).
constexpr double kUnitTolerance = 5e-7;

// A command that a tick takes in; `ticks` since the one before.
void hear(CommandRhythm& rhythm, std::uint64_t ticks, double h) {
  const auto interval = static_cast<double>(ticks);
  if (rhythm.commands == 0 || interval * h > kPause) {
    rhythm = {.interval = std::max(1.0, std::round(kFirstApproach / h)), .deviation = 0, .commands = 1};
  } else {
    // The first interval takes the place of what was assumed.
    const double weight = 1 / std::min(static_cast<double>(rhythm.commands), kMemory);
    const double off = std::abs(interval - rhythm.interval);
    rhythm.deviation += rhythm.commands == 1 ? 0 : weight * (off - rhythm.deviation);
    rhythm.interval += weight * (interval - rhythm.interval);
    ++rhythm.commands;
  }
  rhythm.left = static_cast<std::uint64_t>(std::max(1.0, std::round(rhythm.interval + rhythm.deviation)));
}

// Written so that not-a-number is out of range.
bool in_range(const Pose& pose) {
  return pose.position.array().isFinite().all() && pose.position.cwiseAbs().maxCoeff() <= kMaxPosition &&
         std::abs(pose.orientation.squaredNorm() - 1) <= kUnitTolerance;
}

double length(double x) { return std::abs(x); }
double length(const Vector3& x) { return x.norm(); }

// How far a follower gets in a tick.
struct Pace {
  double tau;    // s; 0: by a share
  double share;  // of the distance, in (0, 1]
  double h;      // s
};

// One tick of the follower for the distance e = x - target; returns the step of x and updates the velocity.
template <class Value>
Value approach(const Value& e, Value& velocity, const Pace& pace, double max_speed) {
  const auto [tau, share, h] = pace;
  Value step;
  if (tau > 0) {
    // e(t) = (e0 + (v0 + e0/tau) t) exp(-t/tau)
    const Value slope = velocity + e / tau;
    const double decay = std::exp(-h / tau);
    step = (e + slope * h) * decay - e;
    velocity = (velocity - slope * (h / tau)) * decay;
  } else {
    step = -share * e;
    velocity = step / h;
  }
  const double size = length(step);
  if (size > max_speed * h) {
    step *= max_speed * h / size;
    velocity = step / h;
    // A follower that comes in faster than its distance over tau would run past the target.
    const double left = length(Value(e + step)), speed = length(velocity);
    if (tau > 0 && speed * tau > left) velocity *= left / (tau * speed);
  }
  return step;
}

}  // namespace

bool in_range(const Command& command) {
  return (!command.pose || in_range(*command.pose)) && (!command.spin || std::abs(*command.spin) <= kMaxSpin);
}

Acceptance limit(const StepLimits& limits, const Pose& base, Command& command) {
  if (!command.pose) return Acceptance::whole;
  const Vector3 step = command.pose->position - base.position;
  const Vector3 turn = rotation_log(command.pose->orientation * base.orientation.conjugate());
  const double far = step.norm() / limits.step, turned = turn.norm() / limits.turn;
  if (far <= 1 && turned <= 1) return Acceptance::whole;
  if (limits.reject) return Acceptance::rejected;
  if (far > 1) command.pose->position = base.position + step / far;
  if (turned > 1) command.pose->orientation = (rotation_exp(turn / turned) * base.orientation).normalized();
  return Acceptance::clamped;
}

void merge(std::optional<Command>& pending, const Command& newer) {
  if (!pending) pending.emplace();
  pending->seq = newer.seq;
  if (newer.pose) pending->pose = newer.pose;
  if (newer.spin) pending->spin = newer.spin;
}

bool at_speed_limit(const BaseLimits& limits, const BaseState& base) {
  constexpr double kAlmost = 1 - 1e-9;
  return base.velocity.norm() > kAlmost * limits.max_speed ||
         base.angular_velocity.norm() > kAlmost * limits.max_angular_speed ||
         (limits.max_spin_speed > 0 && std::abs(base.spin_velocity) > kAlmost * limits.max_spin_speed);
}

BaseState follow(const BaseLimits& limits, double h, const BaseState& base, const std::optional<Command>& newest,
                 std::uint64_t tick) {
  assert(h > 0);
  BaseState next = base;
  if (newest) {
    if (newest->pose) next.target = *newest->pose;
    if (newest->spin) next.target_spin = *newest->spin;
    hear(next.rhythm, tick - base.command_tick, h);
    next.command_seq = newest->seq;
    next.command_tick = tick;
  }
  const double share = limits.tau || next.rhythm.left == 0 ? 1 : 1 / static_cast<double>(next.rhythm.left);
  const Pace pace{limits.tau.value_or(0), share, h};
  if (next.rhythm.left > 0) --next.rhythm.left;
  next.pose.position +=
      approach<Vector3>(next.pose.position - next.target.position, next.velocity, pace, limits.max_speed);
  const Vector3 turned = rotation_log(next.pose.orientation * next.target.orientation.conjugate());
  const Vector3 turn = approach<Vector3>(turned, next.angular_velocity, pace, limits.max_angular_speed);
  // turned and the step share an axis but for what is left of an earlier motion; compose exactly.
  next.pose.orientation = (rotation_exp(turned + turn) * next.target.orientation).normalized();
  const double max_spin_speed = std::min(limits.max_spin_speed, kMaxTurn / h);
  next.spin += approach<double>(next.spin - next.target_spin, next.spin_velocity, pace, max_spin_speed);
  return next;
}

// From tau velocity ahead of a target the follower comes in along an exponential. One that goes by the commands' rhythm
// has long come to where it was told, or its speed limit holds it back.
Command come_to_rest(const BaseLimits& limits, const BaseState& base) {
  const double tau = limits.tau.value_or(0);
  Command command{.seq = base.command_seq, .pose = base.pose, .spin = {}};
  Pose& pose = *command.pose;
  pose.position = (pose.position + tau * base.velocity).cwiseMax(-kMaxPosition).cwiseMin(kMaxPosition);
  pose.orientation = (rotation_exp(tau * base.angular_velocity) * pose.orientation).normalized();
  if (limits.max_spin_speed > 0) command.spin = std::clamp(base.spin + tau * base.spin_velocity, -kMaxSpin, kMaxSpin);
  return command;
}

}  // namespace acus
