// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/study/studies/experiment.h"

#include <algorithm>
#include <cmath>

#include "server/engine/math/processor_time.h"
#include "server/engine/models/geometry/material_point.h"
#include "server/engine/models/geometry/surface.h"
#include "tests/study/bench/calibration.h"
#include "tests/study/bench/trajectory_driver.h"

namespace acus {

namespace {

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

constexpr std::uint64_t kSolves = 20;  // of the calibration, in one run

// The material point at p, or the nearest that the mesh has: a curved surface moves with the mesh.
MaterialPoint material_point_at(const TetrahedralMesh& mesh, const Vector3& p) {
  MaterialPoint best;
  double least = -kInfinity;
  for (int t = 0; t < mesh.tetrahedron_count(); ++t) {
    const Eigen::Vector4d weights = barycentric(mesh, mesh.nodes, t, p);
    if (weights.minCoeff() <= least) continue;
    least = weights.minCoeff();
    best = {t, weights};
  }
  return best;
}

class Probes {
 public:
  Probes(const Simulation& simulation, const Matrix3X& points) : mesh_(simulation.mesh()), rest_(points) {
    for (const auto& p : points.colwise()) material_.push_back(material_point_at(mesh_, p));
  }

  Matrix3X displacements(const Matrix3X& x) const {
    Matrix3X u(3, rest_.cols());
    for (std::size_t i = 0; i < material_.size(); ++i)
      u.col(static_cast<Eigen::Index>(i)) =
          material_position(mesh_, x, material_[i]) - rest_.col(static_cast<Eigen::Index>(i));
    return u;
  }

 private:
  const TetrahedralMesh& mesh_;
  const Matrix3X& rest_;
  std::vector<MaterialPoint> material_;
};

constexpr double kRounding = 10e-3;    // s, to both sides of a corner
constexpr double kSampling = 0.25e-3;  // s, of the rounded motion
constexpr int kHalfWidth = 40;         // samples in kRounding

// Weights of a cubic B-spline that reaches from -kRounding to kRounding, at the samples; their sum is 1.
std::vector<double> spline_weights() {
  std::vector<double> weights;
  double sum = 0;
  for (int k = -kHalfWidth; k <= kHalfWidth; ++k) {
    const double x = 2.0 * std::abs(k) / kHalfWidth;
    weights.push_back(x < 1 ? 2.0 / 3 - x * x + x * x * x / 2 : (2 - x) * (2 - x) * (2 - x) / 6);
    sum += weights.back();
  }
  for (double& w : weights) w /= sum;
  return weights;
}

// The motion with position and spin averaged by the spline, so that acceleration is continuous. Straight stretches and
// rests stay as they are; so does the orientation.
client::Motion rounded(const client::Motion& motion) {
  static const std::vector<double> weights = spline_weights();
  const double begin = motion.samples.front().time;
  const auto count = static_cast<int>(std::lround((motion.samples.back().time - begin + kRounding) / kSampling));
  client::Motion result{motion.needle, {}};
  for (int i = 0; i <= count; ++i) {
    const double time = begin + i * kSampling;
    client::BasePose mean = motion.at(time);
    mean.position.fill(0);
    if (mean.spin) mean.spin = 0;
    for (int k = -kHalfWidth; k <= kHalfWidth; ++k) {
      const client::BasePose pose = motion.at(time + k * kSampling);
      const double w = weights[static_cast<std::size_t>(k + kHalfWidth)];
      for (std::size_t axis = 0; axis < 3; ++axis) mean.position[axis] += w * pose.position[axis];
      if (mean.spin) *mean.spin += w * *pose.spin;
    }
    result.samples.push_back({time, mean});
  }
  return result;
}

void prepare(Recording& recording, const Simulation& simulation, std::uint64_t ticks) {
  recording.h = 1 / simulation.scene().rate;
  recording.tip.assign(simulation.scene().needles.size(), Matrix3X(3, ticks));
  recording.base_force = recording.tip;
}

void note(Recording& recording, const TickReport& report) {
  for (std::size_t i = 0; i < report.needles.size(); ++i) {
    recording.tip[i].col(static_cast<Eigen::Index>(recording.ticks)) = report.needles[i].tip_position;
    recording.base_force[i].col(static_cast<Eigen::Index>(recording.ticks)) = report.needles[i].base_force;
  }
  ++recording.ticks;
  recording.not_converged += (report.flags & (kLawsNotConverged | kNewtonNotConverged)) != 0;
  recording.sweeps += report.sweeps;
  recording.iterations += report.newton_iterations;
  recording.residual = std::max(recording.residual, report.residual);
}

}  // namespace

Experiment read_experiment(const std::string& scenes_folder, const std::string& name, double pace) {
  Experiment experiment{read_scene(scenes_folder + "/" + name + ".yaml"),
                        client::read_trajectory(scenes_folder + "/trajectories/" + name + ".csv")};
  for (Needle& needle : experiment.scene.needles) needle.smoothing = 0;
  for (Guide& guide : experiment.scene.guides) guide.smoothing = 0;
  for (client::Motion& motion : experiment.motion.motions) {
    for (client::Sample& sample : motion.samples) sample.time /= pace;
    motion = rounded(motion);
  }
  return experiment;
}

double duration(const Experiment& experiment) { return experiment.motion.end() - experiment.motion.begin(); }

Recording record(const Experiment& experiment, const Matrix3X& probe_points) {
  Simulation simulation(experiment.scene);
  TrajectoryDriver driver(simulation, experiment.motion, 1 / experiment.scene.rate);
  const Probes probes(simulation, probe_points);
  const auto ticks = static_cast<std::uint64_t>(std::lround(duration(experiment) * experiment.scene.rate));
  const auto ticks_per_probing = static_cast<std::uint64_t>(std::lround(kProbeInterval * experiment.scene.rate));
  Recording recording;
  prepare(recording, simulation, ticks);
  const SparseMatrix matrix = tick_matrix(simulation);
  CholmodSolve calibration(matrix, simulation_order(matrix));
  std::vector<double> solves;
  while (recording.ticks < ticks) {
    if (recording.ticks % (ticks / kSolves + 1) == 0) solves.push_back(processor_time_of([&] { calibration.run(); }));
    driver.command();
    recording.processor_seconds += processor_time_of([&] { simulation.step(); });
    note(recording, simulation.report());
    if (recording.ticks % ticks_per_probing == 0)
      recording.probes.push_back(probes.displacements(simulation.tissue_positions()));
  }
  recording.calibration_seconds = median(solves);
  recording.sweeps /= static_cast<double>(ticks);
  recording.iterations /= static_cast<double>(ticks);
  return recording;
}

Matrix3X nodes_of(const Experiment& experiment) { return load_mesh(experiment.scene).nodes; }

}  // namespace acus
