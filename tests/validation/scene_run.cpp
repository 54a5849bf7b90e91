// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/validation/scene_run.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "server/engine/models/geometry/surface.h"
#include "server/runtime/convert.h"
#include "tests/study/studies/ghosts.h"
#include "tests/study/studies/parabola.h"
#include "tests/support/phases.h"
#include "tests/support/places.h"

namespace acus::test {

namespace {

std::string scene_file(const std::string& name) { return source_path("scenes/") + name + ".yaml"; }

std::string trajectory_file(const std::string& name) { return source_path("scenes/trajectories/") + name + ".csv"; }

bool finite(const NeedleReport& n) {
  const auto all = {n.base.position, n.tip_position,   n.tip_force,     n.base_force,  n.base_torque,
                    n.cutting_force, n.friction_force, n.lateral_force, n.guide_force, n.needle_force};
  return std::all_of(all.begin(), all.end(), [](const Vector3& v) { return v.allFinite(); }) &&
         n.base.orientation.coeffs().allFinite() && std::isfinite(n.inserted_depth);
}

}  // namespace

SceneRun::SceneRun(const std::string& scene, const std::string& trajectory, const Change& change)
    : SceneRun(read_experiment(scene, trajectory, change)) {}

SceneRun::SceneRun(Experiment experiment)
    : simulation_(experiment.scene),
      driver_(simulation_, std::move(experiment.trajectory)),
      surface_(simulation_.mesh()),
      drawn_(simulation_) {}

SceneRun::Experiment SceneRun::read_experiment(const std::string& scene, const std::string& trajectory,
                                               const Change& change) {
  Experiment experiment{read_scene(scene_file(scene)), client::read_trajectory(trajectory_file(trajectory))};
  if (change) change(experiment.scene, experiment.trajectory);
  return experiment;
}

void SceneRun::run() { run_ticks(driver_.ticks()); }

void SceneRun::run_until(double time) { run_ticks(driver_.ticks_until(time)); }

void SceneRun::run_ticks(std::size_t ticks) {
  while (ticks_.size() < ticks) {
    driver_.command();
    simulation_.step();
    ticks_.push_back(simulation_.report());
    drawn_gap_ = std::max(drawn_gap_, drawn_.largest(surface_));
    for (int i = 0; i < static_cast<int>(ticks_.back().needles.size()); ++i) {
      ghosts_ += is_ghost(simulation_, surface_, i) ? 1 : 0;
      const auto needle = static_cast<std::size_t>(i);
      const Phase before = ticks_.size() < 2 ? Phase::free : ticks_[ticks_.size() - 2].needles[needle].phase;
      unexplained_ += explained(ticks_.back().events, i, before, ticks_.back().needles[needle].phase) ? 0 : 1;
    }
  }
}

double SceneRun::resistance(std::size_t tick, std::size_t needle) const {
  const NeedleReport& report = ticks_[tick].needles[needle];
  return -report.base_force.dot(report.base.orientation * Vector3::UnitX());
}

std::vector<Event> SceneRun::events(int needle) const {
  std::vector<Event> found;
  for (const TickReport& tick : ticks_)
    for (const Event& event : tick.events)
      if (event.needle == needle) found.push_back(event);
  return found;
}

const Event* SceneRun::find(EventKind kind, int needle) const {
  for (const TickReport& tick : ticks_)
    for (const Event& event : tick.events)
      if (event.needle == needle && event.kind == kind) return &event;
  return nullptr;
}

int SceneRun::count(EventKind kind, int needle) const {
  const std::vector<Event> all = events(needle);
  return static_cast<int>(std::count_if(all.begin(), all.end(), [&](const Event& e) { return e.kind == kind; }));
}

std::string names(const std::vector<Event>& events, const Scene& scene) {
  std::string all;
  for (const Event& e : events) {
    if (!all.empty()) all += ", ";
    all += protocol::name_of(e.kind) + (" " + scene.tissue.regions[static_cast<std::size_t>(e.region)].name);
  }
  return all;
}

Vector3 rest_position(const Simulation& simulation, const Vector3& p) {
  const TetrahedralMesh& mesh = simulation.mesh();
  const Matrix3X x = simulation.tissue_positions();
  MaterialPoint best;
  double least = -kInfinity;
  for (int t = 0; t < mesh.tetrahedron_count(); ++t) {
    const Eigen::Vector4d weights = barycentric(mesh, x, t, p);
    if (weights.minCoeff() <= least) continue;
    least = weights.minCoeff();
    best = {t, weights};
  }
  return material_position(mesh, mesh.nodes, best);
}

Matrix3X path_at_rest(const Simulation& simulation, int path) {
  Matrix3X points(3, simulation.path_capacity());
  points.conservativeResize(3, simulation.path_positions(path, points));
  for (int i = 0; i < points.cols(); ++i) points.col(i) = rest_position(simulation, points.col(i));
  return points;
}

double curvature(const std::vector<double>& depth, const std::vector<double>& offset, double from, double to,
                 std::size_t least) {
  std::vector<double> d, y;
  for (std::size_t i = 0; i < depth.size(); ++i) {
    if (depth[i] < from || depth[i] > to) continue;
    d.push_back(depth[i]);
    y.push_back(offset[i]);
  }
  REQUIRE(d.size() >= least);
  return parabola_curvature(d, y, (from + to) / 2);
}

void check_sound(const SceneRun& run) {
  constexpr std::uint32_t kMayOccur = kTangentProjected | kForcesUnbalanced | kEnergyGained;
  std::size_t others = 0, projected = 0, unbalanced = 0, gained = 0, broken = 0;
  for (const TickReport& tick : run.ticks()) {
    if ((tick.flags & ~kMayOccur) != 0) ++others;
    if ((tick.flags & kTangentProjected) != 0) ++projected;
    if ((tick.flags & kForcesUnbalanced) != 0) ++unbalanced;
    if ((tick.flags & kEnergyGained) != 0) ++gained;
    if (!std::all_of(tick.needles.begin(), tick.needles.end(), finite)) ++broken;
  }
  CHECK(run.ghosts() == 0);
  CHECK(run.unexplained() == 0);
  CHECK(run.drawn_gap() < kMostDrawnGap);
  CHECK(others == 0);
  CHECK(broken == 0);
  CHECK(projected * 100 < run.ticks().size());   // measured: 0.34 % in inclusion_supported
  CHECK(unbalanced * 100 < run.ticks().size());  // 0.42 % in layers, 0.16 % in liver_insertion
  CHECK(gained <= 1);                            // 8 microjoules, as the soft needle of inclusion_supported snaps
}

}  // namespace acus::test
