// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/study/studies/stability_run.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "server/engine/math/processor_time.h"
#include "server/engine/math/rotation.h"
#include "tests/study/bench/trajectory_driver.h"
#include "tests/study/studies/stability_mesh.h"

namespace acus {

namespace {

constexpr double kStill = 1e-6;  // m/s and rad/s: a base that moves no faster rests

// Of all elements, over their volumes at rest.
double smallest_volume(const TetrahedralMesh& mesh, const Matrix3X& x) {
  double smallest = kInfinity;
  for (int t = 0; t < mesh.tetrahedron_count(); ++t)
    smallest = std::min(smallest, signed_volume(x, mesh.tetrahedra[t]) / rest_volume(mesh, t));
  return smallest;
}

bool touches(const NeedleReport& needle) { return needle.phase != Phase::free; }
bool is_inside(const NeedleReport& needle) { return needle.phase == Phase::inside || needle.phase == Phase::through; }

bool all_finite(const TickReport& report) {
  const auto finite = [](const NeedleReport& n) {
    return n.base_force.allFinite() && n.base_torque.allFinite() && n.tip_force.allFinite() &&
           n.tip_position.allFinite() && std::isfinite(n.inserted_depth);
  };
  return std::isfinite(report.residual) && std::isfinite(report.imbalance) &&
         std::all_of(report.needles.begin(), report.needles.end(), finite);
}

Vector3 turn_between(const Pose& from, const Pose& to) {
  return rotation_log(to.orientation * from.orientation.conjugate());
}

class Recorder {
 public:
  explicit Recorder(const Experiment& experiment)
      : simulation_(experiment.scene), h_(1 / experiment.scene.rate), free_(experiment.scene.tissue.fixed.empty()) {
    for (const NeedleReport& needle : simulation_.report().needles) {
      bases_.push_back(needle.base);
      told_.push_back(needle.commanded);
    }
    series_.forces.resize(2 * bases_.size());
    before_ = simulation_.tissue_positions();
  }

  Simulation& simulation() { return simulation_; }

  void step() {
    series_.seconds += processor_time_of([&] { simulation_.step(); });
    note(simulation_.report());
  }

  StabilitySeries finish() && { return std::move(series_); }

 private:
  void note(const TickReport& report) {
    series_.finite = series_.finite && all_finite(report) && simulation_.tissue_positions().allFinite();
    series_.flags.push_back(report.flags);
    series_.residual.push_back(report.residual);
    const Energy energy = simulation_.energy();
    series_.finite = series_.finite && std::isfinite(energy.total());
    series_.stored.push_back(energy.total());
    series_.kinetic.push_back(energy.kinetic);
    note_volumes(report);
    series_.intrusions += std::ranges::count(report.events, EventKind::intrusion, &Event::kind);
    note_work(report);
    note_contact(report);
    for (std::size_t i = 0; i < bases_.size(); ++i) {
      series_.forces[2 * i].push_back(report.needles[i].base_force);
      series_.forces[2 * i + 1].push_back(report.needles[i].tip_force);
    }
  }

  // The flag speaks of the start of the tick.
  void note_volumes(const TickReport& report) {
    const bool says_so = (report.flags & kElementsInverted) != 0;
    const bool knows = simulation_.scene().tissue.rung != TissueRung::linear;
    series_.unseen_inversion = series_.unseen_inversion || (knows && inverted_ && !says_so);
    const double smallest = smallest_volume(simulation_.mesh(), simulation_.tissue_positions());
    series_.smallest_volume = std::min(series_.smallest_volume, smallest);
    inverted_ = smallest < 0;
  }

  void note_work(const TickReport& report) {
    double work = series_.work.empty() ? 0 : series_.work.back();
    for (std::size_t i = 0; i < bases_.size(); ++i) {
      const NeedleReport& needle = report.needles[i];
      const Vector3 moved = needle.base.position - bases_[i].position;
      work -= needle.base_force.dot(moved) + needle.base_torque.dot(turn_between(bases_[i], needle.base));
      const double told = (needle.commanded.position - told_[i].position).norm();
      if (std::max(told, turn_between(told_[i], needle.commanded).norm()) > kStill * h_) series_.rest = series_.ticks();
      bases_[i] = needle.base;
      told_[i] = needle.commanded;
    }
    series_.work.push_back(work);
  }

  // The tissue's distance is counted from where it is when a needle first touches it.
  void note_contact(const TickReport& report) {
    const bool touched = std::any_of(report.needles.begin(), report.needles.end(), touches);
    for (const NeedleReport& needle : report.needles)
      series_.deepest = std::max(series_.deepest, needle.inserted_depth);
    if (std::any_of(report.needles.begin(), report.needles.end(), is_inside)) series_.last_inside = series_.ticks() - 1;
    touching_for_ = touched ? touching_for_ + 1 : 0;
    series_.withdrawn = touching_for_ < kLeastRest;
    series_.touched = series_.touched || touched;
    if (!series_.touched) before_ = simulation_.tissue_positions();
    const Matrix3X x = simulation_.tissue_positions();
    series_.distance.push_back(free_ ? distance_but_for_rigid_motion(x, before_)
                                     : (x - before_).colwise().norm().maxCoeff());
  }

  Simulation simulation_;
  double h_;
  bool free_;              // nothing supports the tissue
  bool inverted_ = false;  // an element was, at the end of the last tick
  std::size_t touching_for_ = 0;  // ticks since none touched the tissue
  Matrix3X before_;
  std::vector<Pose> bases_;
  std::vector<Pose> told_;
  StabilitySeries series_;
};

}  // namespace

StabilitySeries run_to_rest(const Experiment& experiment) {
  Recorder recorder(experiment);
  TrajectoryDriver driver(recorder.simulation(), experiment.motion, 1 / experiment.scene.rate);
  const std::size_t ticks = std::max(kLeastTicks, driver.ticks() + kLeastRest);
  for (std::size_t k = 0; k < ticks; ++k) {
    driver.command();
    recorder.step();
  }
  return std::move(recorder).finish();
}

double distance_but_for_rigid_motion(const Matrix3X& x, const Matrix3X& reference) {
  if (!x.allFinite()) return kInfinity;
  const Eigen::Matrix4d fit = Eigen::umeyama(x, reference, false);
  const Matrix3X moved = (fit.topLeftCorner<3, 3>() * x).colwise() + fit.topRightCorner<3, 1>();
  return (moved - reference).colwise().norm().maxCoeff();
}

}  // namespace acus
