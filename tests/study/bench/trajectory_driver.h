// SPDX-License-Identifier: GPL-3.0-or-later
// Commands the bodies of a simulation along a trajectory: before every tick each needle and guide gets the pose that it
// has at the tick's start, as acus-replay does in lockstep, or a little later. The caller steps.
#pragma once

#include <cstdint>
#include <vector>

#include "client/replay/trajectory.h"
#include "server/engine/tick/simulation.h"

namespace acus {

class TrajectoryDriver {
 public:
  // `ahead`: how much after a tick's start the pose is due that it is sent (s); with 1/rate, at the tick's end. The
  // simulation must outlive the driver. Throws std::runtime_error for a motion of something that the scene has not.
  TrajectoryDriver(Simulation& simulation, client::Trajectory trajectory, double ahead = 0);

  // How many ticks it takes to play the trajectory to one of its times (s), or to its end.
  std::uint64_t ticks_until(double time) const;
  std::uint64_t ticks() const { return ticks_until(trajectory_.end()); }

  // For the tick that the simulation makes next.
  void command();

 private:
  Simulation& simulation_;
  client::Trajectory trajectory_;
  double ahead_;  // s
  std::vector<int> bodies_;  // per motion, as Simulation::command() numbers them
};

}  // namespace acus
