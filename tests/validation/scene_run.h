// SPDX-License-Identifier: GPL-3.0-or-later
// Runs a scene of scenes/ with its trajectory, in process, and keeps what every tick reports. Needles and guides are
// commanded as acus-replay does it in lockstep: in every tick, with the trajectory's pose at the tick's start.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "client/replay/trajectory.h"
#include "server/engine/models/geometry/surface.h"
#include "server/engine/tick/simulation.h"
#include "tests/study/bench/trajectory_driver.h"
#include "tests/support/drawn_gap.h"

namespace acus::test {

class SceneRun {
 public:
  // Changes the scene and the motion that were read, before the run.
  using Change = std::function<void(Scene&, client::Trajectory&)>;

  // Names without folder and extension.
  explicit SceneRun(const std::string& scene, const std::string& trajectory, const Change& change = {});
  explicit SceneRun(const std::string& scene, const Change& change = {}) : SceneRun(scene, scene, change) {}

  // To the end of the trajectory, or to a time of it (s).
  void run();
  void run_until(double time);

  const Simulation& simulation() const { return simulation_; }
  const Scene& scene() const { return simulation_.scene(); }
  const std::vector<TickReport>& ticks() const { return ticks_; }  // one per tick that was run
  const NeedleReport& needle(std::size_t tick, std::size_t needle = 0) const { return ticks_[tick].needles[needle]; }

  std::size_t ghosts() const { return ghosts_; }            // ticks and needles
  double drawn_gap() const { return drawn_gap_; }           // m, largest (tests/support/drawn_gap.h)
  std::size_t unexplained() const { return unexplained_; }  // likewise: changes of phase without their event

  // Force against insertion (N): of the needle on its holder, against the base's +x axis.
  double resistance(std::size_t tick, std::size_t needle = 0) const;

  std::vector<Event> events(int needle = 0) const;
  // The first event of a kind, or nullptr.
  const Event* find(EventKind kind, int needle = 0) const;
  int count(EventKind kind, int needle = 0) const;

 private:
  struct Experiment {
    Scene scene;
    client::Trajectory trajectory;
  };
  static Experiment read_experiment(const std::string& scene, const std::string& trajectory, const Change& change);
  explicit SceneRun(Experiment experiment);

  void run_ticks(std::size_t ticks);

  Simulation simulation_;
  TrajectoryDriver driver_;
  Surface surface_;
  DrawnGap drawn_;
  double drawn_gap_ = 0;
  std::vector<TickReport> ticks_;
  std::size_t ghosts_ = 0, unexplained_ = 0;
};

// "contact skin, puncture skin, ...": the order of events is easy to compare and to read.
std::string names(const std::vector<Event>& events, const Scene& scene);

// Where material that is at p (m, world) was at rest; for a p outside the tissue, continued from the nearest one.
Vector3 rest_position(const Simulation& simulation, const Vector3& p);

// Points of a path at rest (m, world), the mouth first.
Matrix3X path_at_rest(const Simulation& simulation, int path);

// Curvature (1/m) of a curve, offset over depth (m), between two depths, by a fitted parabola; for slopes below 0.08
// within 1 %. Requires at least `least` points there.
double curvature(const std::vector<double>& depth, const std::vector<double>& offset, double from, double to,
                 std::size_t least);

// What every run must keep to: finite numbers in every report, no ghost and no tip found inside, tips on the drawn skin
// or at the end of the drawn path, and no flag but tangent_projected of a needle near buckling and forces_unbalanced
// where rung warped is far from its balance for a moment, each in fewer than 1 % of the ticks, and energy_gained of a
// needle that snaps, once.
void check_sound(const SceneRun& run);

}  // namespace acus::test
