// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/simulation/base_motion.h"

#include <algorithm>
#include <cmath>

#include "server/math/rotation.h"

namespace acus {

namespace {

constexpr double kUnitTolerance = 1e-3;  // of an orientation's length
constexpr double kLeastTau = 1e-9;       // s; distances over shorter times may be no numbers

double used_tau(double smoothing) { return smoothing < kLeastTau ? 0 : smoothing; }

// Written so that not-a-number is out of range.
bool in_range(const Pose& pose) {
  return pose.position.array().isFinite().all() && pose.position.cwiseAbs().maxCoeff() <= kMaxPosition &&
         std::abs(pose.orientation.norm() - 1) <= kUnitTolerance;
}

bool in_range(const Command& command) {
  return (!command.pose || in_range(*command.pose)) && (!command.spin || std::abs(*command.spin) <= kMaxSpin);
}

double length(double x) { return std::abs(x); }
double length(const Vector3& x) { return x.norm(); }

// One tick of the follower for the distance e = x - target; returns the step of x and updates the velocity.
template <class Value>
Value follow(const Value& e, Value& velocity, double tau, double max_speed, double h) {
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

BaseMotion::BaseMotion(const Needle& p, double h)
    : start_(p.base),
      tau_(used_tau(p.smoothing)),
      max_speed_(p.max_speed),
      max_angular_speed_(p.max_angular_speed),
      max_spin_speed_(p.max_spin_speed),
      h_(h) {
  reset();
}

BaseMotion::BaseMotion(const Guide& p, double h)
    : start_(p.pose),
      tau_(used_tau(p.smoothing)),
      max_speed_(p.max_speed),
      max_angular_speed_(p.max_angular_speed),
      max_spin_speed_(0),
      h_(h) {
  reset();
}

void BaseMotion::reset() {
  pending_.reset();
  target_ = pose_ = start_;
  target_spin_ = spin_ = spin_velocity_ = 0;
  velocity_.setZero();
  angular_velocity_.setZero();
  seq_ = command_tick_ = 0;
}

bool BaseMotion::command(const Command& command) {
  if (!in_range(command)) return false;
  if (!pending_) pending_.emplace();
  pending_->seq = command.seq;
  if (command.pose) pending_->pose = command.pose;
  if (command.spin) pending_->spin = command.spin;
  return true;
}

Pose BaseMotion::advance(std::uint64_t tick) {
  if (pending_) {
    if (pending_->pose) target_ = *pending_->pose;
    if (pending_->spin) target_spin_ = *pending_->spin;
    seq_ = pending_->seq;
    command_tick_ = tick;
    pending_.reset();
  }
  const double tau = tau_;
  pose_.position +=
      follow<Vector3>(pose_.position - target_.position, velocity_, tau, max_speed_, h_);
  const Vector3 turned = rotation_log(pose_.orientation * target_.orientation.conjugate());
  const Vector3 turn = follow<Vector3>(turned, angular_velocity_, tau, max_angular_speed_, h_);
  // turned and the step share an axis but for what is left of an earlier motion; compose exactly.
  pose_.orientation = (rotation_exp(turned + turn) * target_.orientation).normalized();
  // A tick turns by less than half a turn, or nobody could tell which way.
  const double max_spin_speed = std::min(max_spin_speed_, 3.0 / h_);
  spin_ += follow<double>(spin_ - target_spin_, spin_velocity_, tau, max_spin_speed, h_);
  return {pose_.position, (pose_.orientation * rotation_exp({spin_, 0, 0})).normalized()};
}

}  // namespace acus
