// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/validation/insertion_run.h"

#include <cmath>
#include <numbers>

#include "tests/support/places.h"

namespace acus::test {

InsertionRun::InsertionRun(const Scene& scene)
    : simulation_(scene), start_(scene.needles[0].base), axis_(start_.orientation * Vector3::UnitX()) {}

void InsertionRun::tick(double depth) {
  Command command;
  command.seq = ++seq_;
  command.pose = Pose{start_.position + depth * axis_, start_.orientation};
  simulation_.command(0, command);
  simulation_.step();
  const TickReport& report = simulation_.report();
  samples_.push_back({report.time, depth, report, -report.needles[0].base_force.dot(axis_)});
  if (each_) each_(samples_.back());
}

void InsertionRun::run(const std::vector<Leg>& legs, const std::function<void(const Sample&)>& each) {
  each_ = each;
  const double h = 1 / simulation_.scene().rate;
  for (const Leg& leg : legs) {
    const double from = depth_, distance = leg.depth - depth_;
    // Cosine ramps of 0.1 s at both ends; the middle runs at `speed`.
    constexpr double kRamp = 0.1;
    const double duration = std::abs(distance) / leg.speed + kRamp;
    for (double t = h; t < duration + h / 2; t += h) {
      const auto ramped = [&](double x) {  // integral of a cosine ramp from 0 to 1
        x = std::clamp(x, 0.0, kRamp);
        return x / 2 - kRamp / (2 * std::numbers::pi) * std::sin(std::numbers::pi * x / kRamp);
      };
      const double steady = t < kRamp ? 0.0 : std::min(t - kRamp, duration - 2 * kRamp);  // below 0 in short legs
      const double end = std::max(t - (duration - kRamp), 0.0);
      const double travelled = ramped(t) + steady + (end - ramped(end));
      tick(from + std::copysign(std::min(travelled * leg.speed, std::abs(distance)), distance));
    }
    depth_ = leg.depth;
    for (double t = 0; t < leg.hold; t += h) tick(depth_);
  }
  each_ = nullptr;
}

void InsertionRun::idle(double seconds) {
  const auto ticks = static_cast<int>(std::lround(seconds * simulation_.scene().rate));
  for (int i = 0; i < ticks; ++i) tick(depth_);
}

const Event* InsertionRun::find(EventKind kind) const {
  for (const Sample& sample : samples_)
    for (const Event& event : sample.report.events)
      if (event.kind == kind) return &event;
  return nullptr;
}

Scene default_scene() { return read_scene(source_path("scenes/insertion_pullback.yaml")); }

Scene coarse_scene() {
  Scene scene = default_scene();
  scene.tissue.box.cells = {6, 6, 6};
  return scene;
}

}  // namespace acus::test
