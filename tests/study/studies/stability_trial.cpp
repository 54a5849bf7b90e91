// SPDX-License-Identifier: GPL-3.0-or-later
// A trial as an experiment: needles in their places, their motion, the mesh.
#include <cmath>
#include <fstream>
#include <stdexcept>

#include "server/engine/math/rotation.h"
#include "tests/study/studies/stability_cases.h"
#include "tests/study/studies/stability_mesh.h"

namespace acus {

namespace {

constexpr double kJump = 1e-9;  // s, between two samples: a tick sees the one or the other

Pose base_of(const Needle& needle, const Approach& approach, double gap) {
  const Vector3 along = approach.along.normalized();
  const Quaternion turn = rotation_between(Vector3::UnitX(), along);
  return {approach.at - (needle.length + gap) * along, turn};
}

// As many needles as approaches, like the first one but for name and place.
void place_needles(Scene& scene, const Trial& trial) {
  Needle needle = scene.needles[0];
  needle.max_angular_speed = 1e6;
  needle.max_spin_speed = 1e6;
  needle.max_speed = 1e6;
  if (trial.manoeuvre.jumps) needle.smoothing = 0;
  scene.needles.clear();
  for (const Approach& approach : trial.approaches) {
    needle.name = "needle " + std::to_string(scene.needles.size());
    needle.base = base_of(needle, approach, trial.manoeuvre.gap);
    scene.needles.push_back(needle);
  }
}

// Samples of one base, each a way further.
class Journey {
 public:
  Journey(const Needle& needle, const Manoeuvre& manoeuvre) : manoeuvre_(manoeuvre), motion_{needle.name, {}} {
    pose_.orientation = {needle.base.orientation.w(), needle.base.orientation.x(), needle.base.orientation.y(),
                         needle.base.orientation.z()};
    pose_.spin = 0;
    go(needle.base.position, 0);
  }

  void wait(double seconds, double turn = 0) {
    *pose_.spin += turn * seconds;
    go(place_, seconds);
  }
  void move(const Vector3& way, double turn = 0) {
    const double speed = manoeuvre_.speed;
    const double seconds = manoeuvre_.jumps ? kJump : speed > 0 ? way.norm() / speed : 0;
    if (seconds == 0) return;
    *pose_.spin += turn * seconds;
    go(place_ + way, seconds);
  }

  const client::Motion& motion() const { return motion_; }

 private:
  void go(const Vector3& place, double seconds) {
    place_ = place;
    time_ += seconds;
    pose_.position = {place.x(), place.y(), place.z()};
    motion_.samples.push_back({time_, pose_});
  }

  const Manoeuvre& manoeuvre_;
  client::Motion motion_;
  client::BasePose pose_;
  Vector3 place_ = Vector3::Zero();
  double time_ = 0;
};

client::Motion motion_of(const Needle& needle, const Manoeuvre& m) {
  const Vector3 in = (m.gap + m.depth) * (needle.base.orientation * Vector3::UnitX());
  Journey journey(needle, m);
  journey.wait(m.before);
  journey.move(in, m.spin_speed);
  journey.wait(m.hold, m.spin_speed);
  if (!m.aside.isZero()) {
    journey.move(m.aside);
    journey.wait(m.hold);
    journey.move(-m.aside);
    journey.wait(m.hold);
  }
  journey.move(-in);
  return journey.motion();
}

// Gmsh's format 2.2.
void write_gmsh_mesh(const TetrahedralMesh& mesh, const std::string& path) {
  std::ofstream file(path);
  file.precision(17);
  file << "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n" << mesh.node_count() << '\n';
  for (int i = 0; i < mesh.node_count(); ++i) file << i + 1 << ' ' << mesh.nodes.col(i).transpose() << '\n';
  file << "$EndNodes\n$Elements\n" << mesh.tetrahedron_count() << '\n';
  for (int t = 0; t < mesh.tetrahedron_count(); ++t) {
    file << t + 1 << " 4 2 1 1";
    for (const int node : mesh.tetrahedra[t]) file << ' ' << node + 1;
    file << '\n';
  }
  file << "$EndElements\n";
  if (!file.flush()) throw std::runtime_error(path + " cannot be written");
}

void use_slivers(Tissue& tissue, double angle, const std::string& folder) {
  TetrahedralMesh mesh = make_box_mesh(tissue.box.size, tissue.box.cells);
  distort_to_slivers(mesh, angle);
  const std::string path = folder + "/slivers.msh";
  write_gmsh_mesh(mesh, path);
  tissue.gmsh = GmshMesh{path, 1};
}

}  // namespace

Experiment make_experiment(const Trial& trial, const std::string& folder) {
  Experiment experiment{trial.scene, {}};
  place_needles(experiment.scene, trial);
  if (trial.smallest_dihedral > 0) use_slivers(experiment.scene.tissue, trial.smallest_dihedral, folder);
  for (const Needle& needle : experiment.scene.needles)
    experiment.motion.motions.push_back(motion_of(needle, trial.manoeuvre));
  return experiment;
}

}  // namespace acus
