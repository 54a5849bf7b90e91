// SPDX-License-Identifier: GPL-3.0-or-later
// How the base follows its commands: the exact answer of the critically damped follower, limits, long turns.
#include "server/engine/tick/base_motion.h"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "server/engine/math/random.h"
#include "server/engine/math/rotation.h"

namespace acus {
namespace {

constexpr double kPi = std::numbers::pi;

// No limits but those that a test sets.
Needle needle(double tau) {
  Needle n;
  n.smoothing = tau;
  n.max_speed = n.max_angular_speed = n.max_spin_speed = 1e9;
  return n;
}

// A base with its limits and the command that waits for it.
class BaseMotion {
 public:
  template <class Body>
  BaseMotion(const Body& parameters, double h) : limits_(base_limits(parameters)), h_(h), start_(start_of(parameters)) {
    reset();
  }

  void reset() {
    base_ = base_at(start_);
    pending_.reset();
  }
  bool command(const Command& command) {
    if (!in_range(command)) return false;
    merge(pending_, command);
    return true;
  }
  Pose advance(std::uint64_t tick) {
    base_ = follow(limits_, h_, base_, pending_, tick);
    pending_.reset();
    return base_.spun_pose();
  }
  void come_to_rest() { command(acus::come_to_rest(limits_, base_)); }
  const Pose& pose() const { return base_.pose; }
  double spin() const { return base_.spin; }
  std::uint64_t command_seq() const { return base_.command_seq; }
  std::uint64_t command_tick() const { return base_.command_tick; }

 private:
  static Pose start_of(const Needle& needle) { return needle.base; }
  static Pose start_of(const Guide& guide) { return guide.pose; }

  BaseLimits limits_;
  double h_;
  Pose start_;
  BaseState base_;
  std::optional<Command> pending_;
};

Command go_to(const Vector3& position, const Quaternion& orientation = Quaternion::Identity()) {
  return {1, Pose{position, orientation}, std::nullopt};
}

Command spin_to(double angle) { return {1, std::nullopt, angle}; }

double angle_between(const Quaternion& a, const Quaternion& b) { return rotation_log(a * b.conjugate()).norm(); }

TEST_CASE("without a command the base stays, bit for bit") {
  Needle n = needle(5e-3);
  n.base = {{0.1, 0.2, 0.3}, rotation_exp({0.1, 0.2, 0.3})};
  BaseMotion motion(n, 1e-3);
  for (std::uint64_t i = 0; i < 1000; ++i) motion.advance(i);
  CHECK(motion.pose().position == n.base.position);
  CHECK(motion.spin() == 0);
  CHECK(angle_between(motion.pose().orientation, n.base.orientation) < 1e-14);
}

TEST_CASE("from rest the base follows (1 + t/tau) exp(-t/tau), whatever the tick") {
  const double tau = 5e-3;
  const Vector3 target(0.03, -0.02, 0.01), axis = Vector3(1, 2, -2) / 3;
  for (const double h : {1e-4, 1e-3, 2e-3, 1e-2}) {
    const Needle n = needle(tau);
    BaseMotion motion(n, h);
    Command command = go_to(target, rotation_exp(2.0 * axis));
    command.spin = 2;
    motion.command(command);
    double covered = 0;
    for (int i = 1; i * h < 0.08; ++i) {
      motion.advance(static_cast<std::uint64_t>(i));
      const double left = (1 + i * h / tau) * std::exp(-i * h / tau);
      CHECK((motion.pose().position - (1 - left) * target).norm() < 1e-13);
      CHECK(angle_between(motion.pose().orientation, rotation_exp((1 - left) * 2.0 * axis)) < 1e-12);
      CHECK(motion.spin() == doctest::Approx(2 * (1 - left)).epsilon(1e-12));
      CHECK(motion.pose().position.dot(target) >= covered);  // never back
      covered = motion.pose().position.dot(target);
    }
    CHECK(covered <= target.squaredNorm() * (1 + 1e-12));  // never beyond
    CHECK((motion.pose().position - target).norm() < 2e-5 * target.norm());
  }
}

TEST_CASE("a target in steady motion is followed two time constants behind") {
  const double tau = 5e-3, h = 1e-4, speed = 0.1;
  const Needle n = needle(tau);
  BaseMotion motion(n, h);
  double target = 0;
  for (std::uint64_t i = 0; i < 2000; ++i) {
    target += speed * h;
    motion.command(go_to({target, 0, 0}));
    motion.advance(i);
  }
  CHECK(target - motion.pose().position.x() == doctest::Approx(2 * tau * speed).epsilon(0.02));
}

TEST_CASE("no step exceeds the speed limits, and the base still arrives") {
  for (const double tau : {0.0, 5e-3}) {
    Needle n = needle(tau);
    n.max_speed = 0.1;
    n.max_angular_speed = 2;
    n.max_spin_speed = 50;
    const double h = 1e-3;
    BaseMotion motion(n, h);
    Command command = go_to({0.02, 0.03, -0.01}, rotation_exp({0.5, 1, 0.2}));
    command.spin = -20;
    motion.command(command);
    Pose before = motion.pose();
    double spin_before = 0;
    for (std::uint64_t i = 0; i < 1500; ++i) {
      motion.advance(i);
      CHECK((motion.pose().position - before.position).norm() <= n.max_speed * h * (1 + 1e-12));
      CHECK(angle_between(motion.pose().orientation, before.orientation) <= n.max_angular_speed * h * (1 + 1e-9));
      CHECK(std::abs(motion.spin() - spin_before) <= n.max_spin_speed * h * (1 + 1e-12));
      CHECK(motion.spin() >= -20 - 1e-12);
      before = motion.pose();
      spin_before = motion.spin();
    }
    CHECK((motion.pose().position - Vector3(0.02, 0.03, -0.01)).norm() < 1e-12);
    CHECK(angle_between(motion.pose().orientation, rotation_exp({0.5, 1, 0.2})) < 1e-12);
    CHECK(motion.spin() == doctest::Approx(-20).epsilon(1e-12));
  }
}

TEST_CASE("at the speed limit too the base stops without overshoot, however short the time constant") {
  for (const double tau : {1e-4, 2e-4, 5e-4, 1e-3, 5e-3, 5e-2}) {
    for (int i = 0; i < 25; ++i) {
      const double distance = 0.01 + i * 2e-5;  // the last steps before the target are of every size
      Needle n = needle(tau);
      n.max_speed = 0.5;
      BaseMotion motion(n, 1e-3);
      motion.command(go_to({distance, 0, 0}));
      double farthest = 0;
      for (std::uint64_t t = 0; t < 2000; ++t) {
        motion.advance(t);
        farthest = std::max(farthest, motion.pose().position.x());
      }
      CAPTURE(tau);
      CAPTURE(distance);
      CHECK(farthest <= distance * (1 + 1e-9));
      CHECK(motion.pose().position.x() == doctest::Approx(distance).epsilon(1e-6));
    }
  }
}

TEST_CASE("without smoothing the base is at its target after one tick") {
  const Needle n = needle(0);
  BaseMotion motion(n, 1e-3);
  Command command = go_to({0.1, 0.2, 0.3}, rotation_exp({1, -1, 2}));
  command.spin = 2;
  motion.command(command);
  const Pose pose = motion.advance(7);
  CHECK((pose.position - Vector3(0.1, 0.2, 0.3)).norm() < 1e-15);
  CHECK(angle_between(motion.pose().orientation, rotation_exp({1, -1, 2})) < 1e-14);
  CHECK(motion.spin() == 2);
  CHECK(angle_between(pose.orientation, rotation_exp({1, -1, 2}) * rotation_exp({2, 0, 0})) < 1e-12);
}

TEST_CASE("a turn of 180 degrees stays finite and arrives; so does -q") {
  const Quaternion half_turns[] = {{0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, -1}, {0, 0.6, 0, -0.8}};
  for (const double tau : {0.0, 5e-3}) {
    for (const Quaternion& target : half_turns) {
      const Needle n = needle(tau);
      BaseMotion motion(n, 1e-3);
      motion.command(go_to(Vector3::Zero(), target));
      for (std::uint64_t i = 0; i < 300; ++i) {
        motion.advance(i);
        REQUIRE(motion.pose().orientation.coeffs().allFinite());
        CHECK(std::abs(motion.pose().orientation.norm() - 1) < 1e-14);
      }
      CHECK(angle_between(motion.pose().orientation, target) < 1e-9);
    }
  }
  const Needle n = needle(5e-3);
  BaseMotion motion(n, 1e-3);
  motion.command(go_to(Vector3::Zero(), Quaternion(-1, 0, 0, 0)));
  for (std::uint64_t i = 0; i < 100; ++i) {
    motion.advance(i);
    CHECK(angle_between(motion.pose().orientation, Quaternion::Identity()) < 1e-14);
  }
}

TEST_CASE("orientation takes the shorter way round") {
  const Needle n = needle(5e-3);
  BaseMotion motion(n, 1e-3);
  motion.command(go_to(Vector3::Zero(), rotation_exp({0, 0, 1.5 * kPi})));
  for (std::uint64_t i = 0; i < 20; ++i) {
    motion.advance(i);
    const Vector3 turned = rotation_log(motion.pose().orientation);
    CHECK(turned.z() <= 0);
    CHECK(turned.z() >= -kPi / 2 - 1e-12);
  }
}

TEST_CASE("orientations commanded to and fro at random stay unit, finite and within the limit") {
  Needle n = needle(5e-3);
  n.max_angular_speed = 20;
  const double h = 1e-3;
  BaseMotion motion(n, h);
  Random random(1);
  Quaternion before = motion.pose().orientation;
  for (std::uint64_t i = 0; i < 5000; ++i) {
    if (random.index(20) == 0) motion.command(go_to(random.vector(), random.rotation()));
    const Pose pose = motion.advance(i);
    REQUIRE(pose.orientation.coeffs().allFinite());
    CHECK(std::abs(pose.orientation.norm() - 1) < 1e-14);
    CHECK(angle_between(motion.pose().orientation, before) <= n.max_angular_speed * h * (1 + 1e-9));
    before = motion.pose().orientation;
  }
}

TEST_CASE("spin counts its turns") {
  const Needle n = needle(5e-3);
  BaseMotion motion(n, 1e-3);
  motion.command(spin_to(200 * kPi + 0.5));
  Pose pose;
  for (std::uint64_t i = 0; i < 400; ++i) pose = motion.advance(i);
  CHECK(motion.spin() == doctest::Approx(200 * kPi + 0.5).epsilon(1e-12));
  CHECK(angle_between(pose.orientation, rotation_exp({0.5, 0, 0})) < 1e-9);
  CHECK(angle_between(motion.pose().orientation, Quaternion::Identity()) < 1e-14);
}

TEST_CASE("fields that a command leaves out keep their target; the newest command counts") {
  const Needle n = needle(0);
  BaseMotion motion(n, 1e-3);
  motion.command(go_to({1, 0, 0}));
  motion.advance(1);
  motion.command({5, std::nullopt, 1.5});
  motion.command({6, std::nullopt, 2.5});
  motion.advance(2);
  CHECK(motion.pose().position == Vector3(1, 0, 0));
  CHECK(motion.spin() == 2.5);
  CHECK(motion.command_seq() == 6);
  CHECK(motion.command_tick() == 2);
  motion.advance(3);
  CHECK(motion.command_tick() == 2);
}

TEST_CASE("commands of one tick add up, field by field") {
  const Needle n = needle(0);
  BaseMotion motion(n, 1e-3);
  motion.command(go_to({1, 0, 0}));
  motion.command(spin_to(2));
  motion.advance(1);
  CHECK(motion.pose().position == Vector3(1, 0, 0));
  CHECK(motion.spin() == 2);
}

TEST_CASE("a tick never spins by half a turn, whatever the limit says, and the spin still arrives") {
  for (const double tau : {0.0, 5e-3}) {
    for (const double h : {1e-3, 1e-2}) {
      const Needle n = needle(tau);
      BaseMotion motion(n, h);
      motion.command(spin_to(-200));
      for (std::uint64_t i = 0; i < 400; ++i) {
        const double before = motion.spin();
        motion.advance(i);
        CHECK(std::abs(motion.spin() - before) < kPi);
      }
      CHECK(motion.spin() == doctest::Approx(-200).epsilon(1e-9));
    }
  }
}

TEST_CASE("a reset puts the base back and forgets its motion and its command") {
  Needle n = needle(5e-3);
  n.base.position = {0.1, 0, 0};
  BaseMotion motion(n, 1e-3);
  motion.command(go_to({1, 0, 0}));
  motion.advance(1);
  motion.command(go_to({2, 0, 0}));
  motion.reset();
  motion.advance(0);
  CHECK(motion.pose().position == n.base.position);
  CHECK(motion.command_seq() == 0);
}

// The pose and the sequence number after a good command, after the given one and so many ticks.
struct Outcome {
  Vector3 position;
  double spin;
  std::uint64_t seq;

  bool operator==(const Outcome&) const = default;
};

Outcome after(const std::optional<Command>& second, bool between) {
  const Needle n = needle(5e-3);
  BaseMotion motion(n, 1e-3);
  Command good = go_to({0.01, 0.02, 0.03});
  good.spin = 0.5;
  CHECK(motion.command(good));
  if (between) motion.advance(1);
  if (second) CHECK_FALSE(motion.command(*second));
  for (std::uint64_t tick = 2; tick < 100; ++tick) motion.advance(tick);
  return {motion.pose().position, motion.spin(), motion.command_seq()};
}

TEST_CASE("a command out of range is refused as a whole, and the one before it stays, taken in or pending") {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN(), kInf = kInfinity;
  std::vector<Command> refused;
  for (const double bad : {kNan, kInf, -kInf, 1e308, -1e308, std::nextafter(kMaxPosition, kInf)}) {
    refused.push_back({9, Pose{{0, bad, 0}, Quaternion::Identity()}, 2.0});
  }
  for (const double bad : {kNan, kInf, -kInf, 1e307, -1e307, std::nextafter(kMaxSpin, kInf)}) {
    refused.push_back({9, Pose{}, bad});
    refused.push_back({9, std::nullopt, bad});
  }
  for (const double bad : {kNan, kInf, 0.0, 0.9, 1e200}) {
    refused.push_back({9, Pose{Vector3::Zero(), Quaternion(bad, 0, 0, 0)}, 2.0});
  }
  for (const bool between : {false, true}) {
    const Outcome expected = after(std::nullopt, between);
    for (const Command& command : refused) CHECK(after(command, between) == expected);
  }
}

TEST_CASE("the ends of the ranges are taken") {
  const Needle n = needle(5e-3);
  BaseMotion motion(n, 1e-3);
  CHECK(motion.command({1, Pose{{kMaxPosition, -kMaxPosition, 0}, Quaternion::Identity()}, -kMaxSpin}));
  for (std::uint64_t tick = 0; tick < 1000000 && motion.spin() > 1 - kMaxSpin; ++tick) motion.advance(tick);
  CHECK(motion.pose().position.isApprox(Vector3(kMaxPosition, -kMaxPosition, 0)));
  CHECK(motion.spin() == doctest::Approx(-kMaxSpin));
}

TEST_CASE("a smoothing of next to no time is none") {
  BaseMotion motion(needle(1e-300), 1e-3), at_once(needle(0), 1e-3);
  for (BaseMotion* m : {&motion, &at_once}) {
    m->command(go_to({kMaxPosition, 0, 0}));
    for (std::uint64_t tick = 0; tick < 3; ++tick) m->advance(tick);
  }
  CHECK(motion.pose().position == at_once.pose().position);
}

TEST_CASE("a base that is to rest rests a time constant's way on, without turning back or beyond") {
  for (const double tau : {0.0, 2e-3, 0.05}) {
    CAPTURE(tau);
    Needle n = needle(tau);
    n.max_speed = 0.1;
    BaseMotion motion(n, 1e-3);
    Pose far = n.base;
    far.position.x() += 10;
    far.orientation = rotation_exp({0, 0, 1});
    motion.command({.seq = 3, .pose = far, .spin = 2.0});
    for (std::uint64_t tick = 1; tick <= 50; ++tick) motion.advance(tick);
    const Pose at = motion.pose();
    motion.come_to_rest();
    double x = at.position.x();
    for (std::uint64_t tick = 51; tick <= 600; ++tick) {
      motion.advance(tick);
      CHECK(motion.pose().position.x() >= x - 1e-15);
      x = motion.pose().position.x();
    }
    CHECK(x - at.position.x() == doctest::Approx(0.1 * tau).epsilon(1e-3).scale(1e-6));
    CHECK(motion.command_seq() == 3);
  }
}

// Sampled `period` ticks apart, each sample `jitter(k)` ticks late: the base's distance behind (s, by its speed) and
// the largest change of its speed from tick to tick, of its speed, once the rhythm is known.
struct Following {
  double lag = 0, unevenness = 0;
};
template <class Late>
Following follow_steadily(int period, const Late& late) {
  constexpr double kSpeed = 0.05, kStep = 1e-3;  // m/s, s
  Needle n;
  n.max_speed = 1e9;
  BaseMotion motion(n, kStep);
  Following following;
  double before = 0, step_before = 0;
  for (int tick = 1; tick < 3000; ++tick) {
    for (int k = std::max(0, tick / period - 2); k <= tick / period; ++k)
      if (k * period + late(k) == tick) motion.command(go_to({kSpeed * kStep * k * period, 0, 0}));
    motion.advance(static_cast<std::uint64_t>(tick));
    const double x = motion.pose().position.x(), step = x - before;
    if (tick > 1000) {
      following.lag = std::max(following.lag, tick * kStep - x / kSpeed);
      following.unevenness = std::max(following.unevenness, std::abs(step - step_before) / (kSpeed * kStep));
    }
    before = x, step_before = step;
  }
  return following;
}

TEST_CASE("commands at every tick are followed at once, others evenly and a period late") {
  for (const int period : {1, 4, 10, 17}) {
    CAPTURE(period);
    const Following following = follow_steadily(period, [](int) { return 0; });
    CHECK(following.lag <= 1e-3 * period - (period == 1 ? 1e-3 : 0) + 1e-9);
    CHECK(following.unevenness < 1e-6);
  }
}

TEST_CASE("commands that come early and late are followed no more than a tick later than a period and their delay") {
  for (const int period : {4, 10, 17}) {
    CAPTURE(period);
    const Following following = follow_steadily(period, [&](int k) { return (k * 7919) % 3; });
    CHECK(following.lag < 1e-3 * (period + 1 + 2 + 1));
    CHECK(following.unevenness < 1.3);  // it stands still where one is late, and goes on to the next in less time
  }
}

TEST_CASE("a command after a pause is approached in ten milliseconds, evenly") {
  Needle n;
  BaseMotion motion(n, 1e-3);
  motion.command(go_to({1e-3, 0, 0}));
  for (std::uint64_t tick = 500; tick < 510; ++tick) {
    motion.advance(tick);
    CHECK(motion.pose().position.x() == doctest::Approx(1e-4 * static_cast<double>(tick - 499)));
  }
  CHECK(motion.pose().position.x() == doctest::Approx(1e-3));
}

TEST_CASE("a command's orientation is of unit length, but for rounding") {
  const auto command = [](double w) { return Command{1, Pose{{0, 0, 0}, Quaternion(w, 0, 0, 0)}, {}}; };
  for (const double off : {0.0, 1e-15, -1e-7, 1e-7}) CHECK(in_range(command(1 + off)));
  for (const double off : {-4e-5, 4e-5, 1e-6, -1.0, std::nan("")}) CHECK_FALSE(in_range(command(1 + off)));
}

}  // namespace
}  // namespace acus
