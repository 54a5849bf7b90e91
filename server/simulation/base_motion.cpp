// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/simulation/base_motion.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "server/math/rotation.h"

namespace acus {

namespace {

constexpr double kLeastTau = 1e-9;       // s; distances over shorter times may be no numbers
constexpr double kMaxTurn = 3;           // rad of spin in a tick: less than half a turn, or nobody could tell which way

double used_tau(double smoothing) { return smoothing < kLeastTau ? 0 : smoothing; }

// Written so that not-a-number is out of range.
bool in_range(const Pose& pose) {
  return pose.position.array().isFinite().all() && pose.position.cwiseAbs().maxCoeff() <= kMaxPosition &&
         std::abs(pose.orientation.norm() - 1) <= protocol::kQuaternionTolerance;
}

double length(double x) { return std::abs(x); }
double length(const Vector3& x) { return x.norm(); }

// One tick of the follower for the distance e = x - target; returns the step of x and updates the velocity.
template <class Value>
Value approach(const Value& e, Value& velocity, double tau, double max_speed, double h) {
  Value step;
  if (tau > 0) {
    // e(t) = (e0 + (v0 + e0/tau) t) exp(-t/tau)
    const Value slope = velocity + e / tau;
    const double decay = std::exp(-h / tau);
    step = (e + slope * h) * decay - e;
    velocity = (velocity - slope * (h / tau)) * decay;
  } else {
    step = -e;
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

void merge(std::optional<Command>& pending, const Command& newer) {
  if (!pending) pending.emplace();
  pending->seq = newer.seq;
  if (newer.pose) pending->pose = newer.pose;
  if (newer.spin) pending->spin = newer.spin;
}

BaseLimits base_limits(const Needle& p) {
  return {used_tau(p.smoothing), p.max_speed, p.max_angular_speed, p.max_spin_speed};
}

BaseLimits base_limits(const Guide& p) { return {used_tau(p.smoothing), p.max_speed, p.max_angular_speed, 0}; }

Pose BaseState::spun_pose() const {
  return {pose.position, (pose.orientation * rotation_exp({spin, 0, 0})).normalized()};
}

bool BaseState::is_finite() const {
  for (const Pose* p : {&pose, &target})
    if (!p->position.array().isFinite().all() || !p->orientation.coeffs().array().isFinite().all()) return false;
  return velocity.array().isFinite().all() && angular_velocity.array().isFinite().all() && std::isfinite(spin) &&
         std::isfinite(target_spin) && std::isfinite(spin_velocity);
}

BaseState base_at(const Pose& pose) {
  BaseState base;
  base.pose = base.target = pose;
  return base;
}

BaseState follow(const BaseLimits& limits, double h, const BaseState& base, const std::optional<Command>& newest,
                 std::uint64_t tick) {
  assert(h > 0);
  BaseState next = base;
  if (newest) {
    if (newest->pose) next.target = *newest->pose;
    if (newest->spin) next.target_spin = *newest->spin;
    next.command_seq = newest->seq;
    next.command_tick = tick;
  }
  next.pose.position +=
      approach<Vector3>(next.pose.position - next.target.position, next.velocity, limits.tau, limits.max_speed, h);
  const Vector3 turned = rotation_log(next.pose.orientation * next.target.orientation.conjugate());
  const Vector3 turn =
      approach<Vector3>(turned, next.angular_velocity, limits.tau, limits.max_angular_speed, h);
  // turned and the step share an axis but for what is left of an earlier motion; compose exactly.
  next.pose.orientation = (rotation_exp(turned + turn) * next.target.orientation).normalized();
  const double max_spin_speed = std::min(limits.max_spin_speed, kMaxTurn / h);
  next.spin += approach<double>(next.spin - next.target_spin, next.spin_velocity, limits.tau, max_spin_speed, h);
  return next;
}

// From tau velocity ahead of a target the follower comes in along an exponential.
Command come_to_rest(const BaseLimits& limits, const BaseState& base) {
  Command command{.seq = base.command_seq, .pose = base.pose, .spin = {}};
  Pose& pose = *command.pose;
  pose.position = (pose.position + limits.tau * base.velocity).cwiseMax(-kMaxPosition).cwiseMin(kMaxPosition);
  pose.orientation = (rotation_exp(limits.tau * base.angular_velocity) * pose.orientation).normalized();
  if (limits.max_spin_speed > 0)
    command.spin = std::clamp(base.spin + limits.tau * base.spin_velocity, -kMaxSpin, kMaxSpin);
  return command;
}

}  // namespace acus
