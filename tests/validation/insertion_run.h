// SPDX-License-Identifier: GPL-3.0-or-later
// Drives one needle of a scene straight along its own axis, tick by tick, and keeps what it felt.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "server/engine/tick/simulation.h"

namespace acus::test {

// A leg of the motion: the base moves to `depth` (m, along the needle's axis from its start) at `speed` (m/s) with
// smooth ends, then waits for `hold` (s).
struct Leg {
  double depth;
  double speed;
  double hold = 0;
};

struct Sample {
  double time;        // s
  double commanded;   // m, along the axis
  TickReport report;
  double resistance;  // N, along the axis, positive against insertion
};

class InsertionRun {
 public:
  explicit InsertionRun(const Scene& scene);

  // Runs the legs one after another; `each` sees every tick. Samples are kept if keep is on.
  void run(const std::vector<Leg>& legs, const std::function<void(const Sample&)>& each = {});
  void idle(double seconds);

  Simulation& simulation() { return simulation_; }
  const std::vector<Sample>& samples() const { return samples_; }
  const Sample& last() const { return samples_.back(); }
  // The first event of a kind, or nullptr.
  const Event* find(EventKind kind) const;

 private:
  void tick(double depth);

  Simulation simulation_;
  Pose start_;
  Vector3 axis_;
  double depth_ = 0;
  std::uint64_t seq_ = 0;
  std::vector<Sample> samples_;
  std::function<void(const Sample&)> each_;
};

// scenes/insertion_pullback.yaml, the scene that the project shows first.
Scene default_scene();
// The same with elements of twice the size: 6 x 6 x 6 cells.
Scene coarse_scene();

}  // namespace acus::test
