// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/study/studies/mesh_dependence.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "server/engine/math/rotation.h"
#include "server/engine/scene/scene_fields.h"
#include "server/engine/tick/simulation.h"
#include "tests/study/studies/csv.h"
#include "tests/study/studies/parabola.h"

namespace acus {

namespace {

constexpr double kEdge = 0.06;            // m, of the block
constexpr double kTick = 0.02;            // s
constexpr double kClearance = 0.1e-3;     // m, of the tip above the surface at the start
constexpr double kPressStep = 0.1e-3;     // m per tick
constexpr int kMostPressSteps = 80;       // until the surface has given way
constexpr double kStep = 0.5e-3;          // m per tick, inside
constexpr double kDepth = 30e-3;          // m, that the rigid needle is pushed to
constexpr double kDragged = 40e-3;        // m, way past the surface of the base of a needle that drags the skin
constexpr double kSteeringDepth = 45e-3;  // m
constexpr double kSteeringFrom = 20e-3;   // m, where the tip's way has taken on its radius
constexpr double kPressForce = 0.1;       // N
constexpr double kPressDepth = 0.3e-3;    // m
constexpr double kPullBack = 20e-6;       // m
constexpr double kAside = 0.1e-3;         // m
constexpr int kRest = 5;                  // ticks
constexpr double kRigidFoundation = 1e7;  // Pa, hundreds of times what a mesh has
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

struct Setting {
  TissueElement element;
  LocalCompliance give;
  double poisson_ratio;
  int cells;
};

std::vector<Setting> settings(bool quick) {
  std::vector<Setting> all;
  const auto add = [&](TissueElement element, LocalCompliance give) {
    for (const double poisson_ratio : quick ? std::vector{0.45} : std::vector{0.45, 0.49})
      for (const int cells : quick ? std::vector{4, 8} : std::vector{5, 8, 12, 20})
        all.push_back({element, give, poisson_ratio, cells});
  };
  for (const TissueElement element : {TissueElement::linear, TissueElement::nodal_pressure})
    for (const LocalCompliance give : {LocalCompliance::none, LocalCompliance::all}) add(element, give);
  return all;
}

Volume outside(int axis, int side) {
  constexpr double kFace = kEdge / 2 - 1e-6;
  Volume volume;
  volume.box = Box{};
  (side < 0 ? volume.box->max : volume.box->min)[axis] = side * kFace;
  return volume;
}

Region region_of(const Setting& setting) {
  Region region;
  region.material.young_modulus = 30e3;
  region.material.poisson_ratio = setting.poisson_ratio;
  region.material.rayleigh_stiffness = 0;
  region.interaction = {.puncture_force = 0.3, .cutting_force = 0.15, .pressure = 3e3, .foundation_stiffness = {}};
  if (setting.give == LocalCompliance::none) region.interaction.foundation_stiffness = kRigidFoundation;
  return region;
}

// Off the middle and off the nodes, pointing down.
Needle needle_above(double length, double diameter) {
  Needle needle;
  needle.length = length;
  needle.outer_diameter = diameter;
  needle.constraint_spacing = 3e-3;
  needle.smoothing = 0;
  needle.base.position = {1.3e-3, 2.1e-3, kEdge / 2 + kClearance + length};
  needle.base.orientation = rotation_between(Vector3::UnitX(), -Vector3::UnitZ());
  return needle;
}

Scene scene_of(const Setting& setting, const Needle& needle) {
  Scene scene;
  scene.rate = 1 / kTick;
  scene.tissue.element = setting.element;
  scene.tissue.local_compliance = setting.give;
  scene.tissue.box.size.setConstant(kEdge);
  scene.tissue.box.cells.fill(setting.cells);
  scene.tissue.regions = {region_of(setting)};
  scene.tissue.fixed = {outside(0, -1), outside(0, 1), outside(1, -1), outside(1, 1), outside(2, -1)};
  scene.needles = {needle};
  return scene;
}

Scene straight_scene(const Setting& setting) {
  Needle needle = needle_above(0.06, 1e-3);
  needle.rung = NeedleRung::rigid;
  return scene_of(setting, needle);
}

Scene dragging_scene(const Setting& setting) {
  Scene scene = straight_scene(setting);
  scene.tissue.regions[0].material.young_modulus = 10e3;
  Interaction& law = scene.tissue.regions[0].interaction;
  law.puncture_force = 0.5;
  law.cutting_force = 0.3;
  law.pressure = 20e3;
  law.friction_static = law.friction_dynamic = 0.5;
  return scene;
}

// A wire in a guide at the surface. Its tip's frame has +y along the world's.
Scene steering_scene(const Setting& setting) {
  Needle needle = needle_above(0.07, 0.4e-3);
  needle.beams = 60;
  needle.material.young_modulus = 60e9;
  needle.cutting_direction = {1, 0.06, 0};
  Scene scene = scene_of(setting, needle);
  Interaction& law = scene.tissue.regions[0].interaction;
  law.puncture_force = law.cutting_force = 0.05;
  law.pressure = 500;
  Guide guide;
  guide.pose = {{needle.base.position.x(), needle.base.position.y(), kEdge / 2 + kClearance / 2},
                needle.base.orientation};
  scene.guides = {guide};
  return scene;
}

// A needle whose base is moved from one tick to the next.
class Motion {
 public:
  explicit Motion(const Scene& scene) : simulation_(scene), base_(scene.needles[0].base) {}

  void move(const Vector3& by) {
    base_.position += by;
    simulation_.command(0, {++seq_, base_, 0.0});
    simulation_.step();
  }
  void push(double by) { move(by * axis()); }
  void wait(int ticks) {
    for (int i = 0; i < ticks; ++i) move(Vector3::Zero());
  }

  Vector3 axis() const { return base_.orientation * Vector3::UnitX(); }
  const NeedleReport& needle() const { return simulation_.report().needles[0]; }
  double travel() const { return (needle().base.position - simulation_.scene().needles[0].base.position).dot(axis()); }
  double resistance() const { return -needle().base_force.dot(axis()); }

 private:
  Simulation simulation_;
  Pose base_;
  std::uint64_t seq_ = 0;
};

// y at x along a polyline with growing x; NaN beyond its end.
double interpolate(const std::vector<double>& xs, const std::vector<double>& ys, double x) {
  const auto next = std::lower_bound(xs.begin(), xs.end(), x);
  if (next == xs.end()) return kNone;
  const auto i = next - xs.begin();
  if (i == 0) return ys[0];
  const double u = (x - xs[i - 1]) / (xs[i] - xs[i - 1]);
  return (1 - u) * ys[i - 1] + u * ys[i];
}

// Until the surface has given way.
void press(Motion& motion, MeshRow& row) {
  std::vector<double> depths{0}, forces{0};
  for (int i = 0; i < kMostPressSteps && motion.needle().phase != Phase::inside; ++i) {
    motion.push(kPressStep);
    const double force = motion.resistance();
    if (force <= forces.back()) continue;
    depths.push_back(motion.travel() - kClearance);
    forces.push_back(force);
  }
  row.indentation = interpolate(forces, depths, kPressForce);
  row.press_force = interpolate(depths, forces, kPressDepth);
  row.puncture_depth = depths.back();
  row.base_peak = forces.back();
}

void push_in(Motion& motion, MeshRow& row) {
  double sum = 0;
  int count = 0;
  while (motion.travel() - kClearance < kDepth) {
    motion.push(kStep);
    row.base_peak = std::max(row.base_peak, motion.resistance());
    if (motion.travel() - kClearance < kDepth - 5e-3) continue;
    sum += motion.resistance();
    ++count;
  }
  row.base_force = sum / count;
}

void drag(Motion& motion, MeshRow& row) {
  double sum = 0;
  int count = 0;
  while (motion.travel() - kClearance < kDragged) {
    motion.push(kStep / 2);
    if (motion.travel() - kClearance < kDragged - 5e-3) continue;
    sum += motion.resistance();
    ++count;
  }
  row.dragged_force = sum / count;
  row.dragged_depth = motion.needle().inserted_depth;
}

// Stiffness (N/m) against a small motion of the base.
double stiffness(Motion& motion, const Vector3& by) {
  const auto force = [&] { return motion.needle().base_force.dot(by.normalized()); };
  motion.wait(kRest);
  const double before = force();
  motion.move(by);
  motion.wait(kRest);
  return (before - force()) / by.norm();
}

double steering_radius(const Setting& setting) {
  Motion motion(steering_scene(setting));
  std::vector<double> depths, offsets;
  while (motion.travel() - kClearance < kSteeringDepth) {
    motion.push(kStep);
    const Vector3& tip = motion.needle().tip_position;
    const double depth = kEdge / 2 - tip.z();
    if (depth < kSteeringFrom) continue;
    depths.push_back(depth);
    offsets.push_back(tip.y());  // the bevel steers towards the base's +y, which is the world's
  }
  return 1 / std::abs(parabola_curvature(depths, offsets, (depths.front() + depths.back()) / 2));
}

MeshRow measure(const Setting& setting, bool steering) {
  MeshRow row{setting.element, setting.give, setting.poisson_ratio, setting.cells};
  Motion motion(straight_scene(setting));
  press(motion, row);
  push_in(motion, row);
  row.axial_stiffness = stiffness(motion, -kPullBack * motion.axis());
  row.lateral_stiffness = stiffness(motion, kAside * Vector3::UnitX());
  Motion dragging(dragging_scene(setting));
  drag(dragging, row);
  row.steering_radius = steering ? steering_radius(setting) : kNone;
  return row;
}

}  // namespace

std::vector<MeshRow> mesh_table(bool quick,
                                const std::function<void(int done, int of, const std::string& next)>& progress) {
  std::vector<MeshRow> rows;
  const std::vector<Setting> all = settings(quick);
  for (const Setting& s : all) {
    progress(
        static_cast<int>(rows.size()), static_cast<int>(all.size()),
        std::string(name_of(s.element)) + ", added " + name_of(s.give) + ", " + std::to_string(s.cells) + " cells");
    rows.push_back(measure(s, !quick));
  }
  return rows;
}

void study_mesh_dependence(const StudyPlan& plan) {
  CsvFile file(plan.out + "/mesh_dependence.csv",
               {"element", "added", "poisson_ratio", "cells", "element_size", "indentation", "press_force",
                "puncture_depth", "base_force", "base_peak", "axial_stiffness", "lateral_stiffness", "dragged_force",
                "dragged_depth", "steering_radius"});
  for (const MeshRow& r : mesh_table(plan.quick, plan.progress))
    file.row({name_of(r.element), name_of(r.give), r.poisson_ratio, r.cells, kEdge / r.cells, r.indentation,
              r.press_force, r.puncture_depth, r.base_force, r.base_peak, r.axial_stiffness, r.lateral_stiffness,
              r.dragged_force, r.dragged_depth, r.steering_radius});
}

}  // namespace acus
