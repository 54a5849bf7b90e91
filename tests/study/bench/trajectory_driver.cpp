// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/study/bench/trajectory_driver.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace acus {

namespace {

// The number of a needle or guide for Simulation::command().
int body_number(const Scene& scene, const std::string& name) {
  const auto named = [&](const auto& body) { return body.name == name; };
  const auto needle = std::find_if(scene.needles.begin(), scene.needles.end(), named);
  if (needle != scene.needles.end()) return static_cast<int>(needle - scene.needles.begin());
  const auto guide = std::find_if(scene.guides.begin(), scene.guides.end(), named);
  if (guide == scene.guides.end())
    throw std::runtime_error("the trajectory moves '" + name + "', but scene '" + scene.name +
                             "' has no needle or guide of that name");
  return static_cast<int>(scene.needles.size() + static_cast<std::size_t>(guide - scene.guides.begin()));
}

Command command_of(const client::BasePose& pose, std::uint64_t seq) {
  const auto& q = pose.orientation;
  return {
      .seq = seq, .pose = Pose{Vector3(pose.position.data()), Quaternion(q[0], q[1], q[2], q[3])}, .spin = pose.spin};
}

}  // namespace

TrajectoryDriver::TrajectoryDriver(Simulation& simulation, client::Trajectory trajectory, double ahead)
    : simulation_(simulation), trajectory_(std::move(trajectory)), ahead_(ahead) {
  for (const client::Motion& motion : trajectory_.motions)
    bodies_.push_back(body_number(simulation_.scene(), motion.needle));
}

std::uint64_t TrajectoryDriver::ticks_until(double time) const {
  const double intervals = std::ceil((time - trajectory_.begin()) * simulation_.scene().rate);
  return static_cast<std::uint64_t>(std::max(intervals, 0.0)) + 1;
}

void TrajectoryDriver::command() {
  const std::uint64_t tick = simulation_.report().tick;
  const double now = trajectory_.begin() + static_cast<double>(tick) / simulation_.scene().rate + ahead_;
  for (std::size_t i = 0; i < bodies_.size(); ++i)
    simulation_.command(bodies_[i], command_of(trajectory_.motions[i].at(now), tick + 1));
}

}  // namespace acus
