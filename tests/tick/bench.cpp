// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/tick/bench.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "server/engine/math/rotation.h"
#include "tests/study/studies/ghosts.h"
#include "tests/support/phases.h"

namespace acus::test {

Needle needle_at(const Vector3& at, double above, bool down) {
  Needle needle;
  needle.length = 0.1;
  needle.beams = 25;
  needle.base.orientation = rotation_exp({0, (down ? 1 : -1) * std::numbers::pi / 2, 0});
  needle.base.position = at - (needle.length + above) * (needle.base.orientation * Vector3::UnitX());
  return needle;
}

Scene block_scene(double height) {
  Scene scene;
  scene.rate = 500;
  scene.tissue.box.size = {0.06, 0.06, height};
  scene.tissue.box.cells = {6, 6, 6};
  Region& region = scene.tissue.regions[0];
  region.material.young_modulus = 20e3;
  region.interaction = {.puncture_force = 0.4, .cutting_force = 0.2, .pressure = 6e3, .foundation_stiffness = {}};
  region.interaction.friction_static = 0.35;
  region.interaction.friction_dynamic = 0.3;
  const auto hold = [&](const Vector3& min, const Vector3& max) {
    scene.tissue.fixed.emplace_back().box = Box{min, max};
  };
  const Vector3 all = Vector3::Constant(kInfinity);
  hold(-all, {-0.03, kInfinity, kInfinity});
  hold({0.03, -kInfinity, -kInfinity}, all);
  hold(-all, {kInfinity, -0.03, kInfinity});
  hold({-kInfinity, 0.03, -kInfinity}, all);
  scene.needles = {needle_at({0.003, 0.002, height / 2}, 0.005)};
  return scene;
}

Bench::Bench(const Scene& scene) : simulation_(scene), surface_(simulation_.mesh()), drawn_(simulation_) {
  for (const Needle& needle : scene.needles) commands_.push_back({.seq = 0, .pose = needle.base, .spin = 0});
  phases_.resize(scene.needles.size(), Phase::free);
  for (const Guide& guide : scene.guides) commands_.push_back({.seq = 0, .pose = guide.pose, .spin = {}});
}

void Bench::tick() {
  for (std::size_t body = 0; body < commands_.size(); ++body) {
    ++commands_[body].seq;
    simulation_.command(static_cast<int>(body), commands_[body]);
  }
  simulation_.step();
  const TickReport& report = simulation_.report();
  flags_ |= report.flags;
  events_.insert(events_.end(), report.events.begin(), report.events.end());
  for (const NeedleReport& n : report.needles)
    finite_ = finite_ && n.base_force.allFinite() && n.base_torque.allFinite() && n.tip_position.allFinite();
  check_invariants();
  if (each_tick) each_tick();
}

void Bench::check_invariants() {
  const TickReport& report = simulation_.report();
  CAPTURE(report.tick);
  for (int i = 0; i < static_cast<int>(report.needles.size()); ++i) {
    CHECK_FALSE(is_ghost(simulation_, surface_, i));
    Phase& before = phases_[static_cast<std::size_t>(i)];
    CHECK(explained(report.events, i, before, needle(i).phase));
    before = needle(i).phase;
  }
  CHECK(drawn_.largest(surface_) < kMostDrawnGap);
  for (const Event& event : report.events) CHECK((may_intrude || event.kind != EventKind::intrusion));
}

void Bench::move(int body, const Vector3& by, double speed) {
  Pose& pose = *commands_[static_cast<std::size_t>(body)].pose;
  const Vector3 from = pose.position;
  const double ticks = std::ceil(by.norm() / speed * simulation_.scene().rate);
  for (double i = 1; i <= ticks; ++i) {
    pose.position = from + i / ticks * by;
    tick();
  }
}

void Bench::turn(int body, const Vector3& by, double rate) {
  Pose& pose = *commands_[static_cast<std::size_t>(body)].pose;
  const Quaternion from = pose.orientation;
  const double ticks = std::ceil(by.norm() / rate * simulation_.scene().rate);
  for (double i = 1; i <= ticks; ++i) {
    pose.orientation = (rotation_exp(i / ticks * by) * from).normalized();
    tick();
  }
}

void Bench::push(int needle, double by, double speed) { move(needle, by * axis(needle), speed); }

void Bench::spin(int needle, double to, double rate) {
  double& spin = *commands_[static_cast<std::size_t>(needle)].spin;
  const double from = spin, ticks = std::ceil(std::abs(to - from) / rate * simulation_.scene().rate);
  for (double i = 1; i <= ticks; ++i) {
    spin = from + i / ticks * (to - from);
    tick();
  }
}

void Bench::screw(int needle, double by, double speed, double rate) {
  Command& command = commands_[static_cast<std::size_t>(needle)];
  const Vector3 from = command.pose->position, along = by * axis(needle);
  const double ticks = std::ceil(std::abs(by) / speed * simulation_.scene().rate);
  for (double i = 1; i <= ticks; ++i) {
    command.pose->position = from + i / ticks * along;
    *command.spin += rate / simulation_.scene().rate;
    tick();
  }
}

void Bench::wait(double seconds) {
  const auto ticks = std::lround(seconds * simulation_.scene().rate);
  for (long i = 0; i < ticks; ++i) tick();
}

Vector3 Bench::axis(int needle) const {
  return commands_[static_cast<std::size_t>(needle)].pose->orientation * Vector3::UnitX();
}

double Bench::resistance(int needle) const { return -this->needle(needle).base_force.dot(axis(needle)); }

double Bench::twist(int needle) const {
  double sum = 0;
  const auto q = simulation_.needle_orientations(needle);
  for (std::size_t i = 1; i < q.size(); ++i) sum += rotation_log(q[i - 1].conjugate() * q[i]).x();
  return sum;
}

double Bench::tissue_displacement() const {
  return (simulation_.tissue_positions() - simulation_.mesh().nodes).cwiseAbs().maxCoeff();
}

std::vector<Event> Bench::events(EventKind kind, int needle) const {
  std::vector<Event> found;
  std::copy_if(events_.begin(), events_.end(), std::back_inserter(found),
               [&](const Event& e) { return e.kind == kind && e.needle == needle; });
  return found;
}

}  // namespace acus::test
