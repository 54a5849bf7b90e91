// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/study/studies/entries.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <numbers>

#include "server/engine/math/processor_time.h"
#include "server/engine/math/random.h"
#include "server/engine/math/rotation.h"
#include "server/engine/models/geometry/surface.h"
#include "server/engine/models/unresolved/dimple.h"
#include "server/engine/tick/simulation.h"
#include "tests/study/studies/experiment.h"
#include "tests/study/studies/ghosts.h"

namespace acus {

namespace {

constexpr double kLargestForce = 4;     // N, of f_p: what the needle bears without buckling
constexpr double kNeedleLength = 0.12, kDiameter = 2e-3;  // m
constexpr double kWay = 60e-3;          // m, of a base, at most
constexpr double kWayOfTick = 0.15e-3;  // m, of a slow base: the rate follows from it
constexpr double kLeastRate = 100, kLargestRate = 1000;  // Hz

double log_uniform(Random& random, double low, double high) {
  return low * std::pow(high / low, random.uniform(0, 1));
}

// One in a hundred is exact, which takes a hundred times as long.
TissueRung pick_rung(int number, Random& random) {
  constexpr std::array kRungs{TissueRung::linear, TissueRung::warped, TissueRung::warped, TissueRung::refined};
  const TissueRung picked = kRungs[static_cast<std::size_t>(random.index(static_cast<int>(kRungs.size())))];
  return number % 100 == 99 ? TissueRung::exact : picked;
}

// Blocks of 10 to 14 cells of 3 to 8 mm along each side.
void make_block(Scene& scene, Random& random) {
  const double cell = log_uniform(random, 3e-3, 8e-3);
  const std::array<int, 3> cells{10 + random.index(5), 10 + random.index(5), 8 + random.index(4)};
  scene.tissue.box = {Vector3(cells[0] * cell, cells[1] * cell, cells[2] * cell), cells};
}

struct Spot {
  Vector3 at, normal;
  int tetrahedron = -1;
};

// A random point of the boundary of the mesh, weighed by area, whose normal is within 60 degrees of `up`.
Spot pick_spot(const TetrahedralMesh& mesh, const Vector3& up, Random& random) {
  std::vector<double> sums;
  double sum = 0;
  const auto edges = [&](std::size_t i) {
    const auto& t = mesh.surface[i];
    const Vector3 a = mesh.nodes.col(t[0]);
    return std::pair<Vector3, Vector3>(mesh.nodes.col(t[1]) - a, mesh.nodes.col(t[2]) - a);
  };
  for (std::size_t i = 0; i < mesh.surface.size(); ++i) {
    const auto [e, f] = edges(i);
    const Vector3 area = e.cross(f) / 2;
    sums.push_back(sum += area.dot(up) > 0.5 * area.norm() ? area.norm() : 0.0);
  }
  const double pick = random.uniform(0, sum);
  const auto i = static_cast<std::size_t>(std::lower_bound(sums.begin(), sums.end(), pick) - sums.begin());
  const auto [e, f] = edges(i);
  double u = random.uniform(0, 1), v = random.uniform(0, 1);
  if (u + v > 1) u = 1 - u, v = 1 - v;
  return {mesh.nodes.col(mesh.surface[i][0]) + u * e + v * f, e.cross(f).normalized(), mesh.surface_tetrahedron[i]};
}

// What lies furthest behind the entry: a fiftieth of the tissue's extent along `up`.
Volume far_side(const TetrahedralMesh& mesh, const Vector3& up) {
  const Eigen::RowVectorXd heights = up.transpose() * mesh.nodes;
  const double low = heights.minCoeff(), high = heights.maxCoeff();
  Volume volume;
  volume.half_space = HalfSpace{(low + 0.02 * (high - low)) * up, up};
  return volume;
}

Needle make_needle(const Entry& entry) {
  Needle needle;
  needle.length = kNeedleLength;
  needle.beams = 24;
  needle.outer_diameter = kDiameter;
  needle.constraint_spacing = 4e-3;
  needle.smoothing = 0;
  needle.max_speed = 1e6;
  needle.base = {entry.at - (needle.length + entry.gap) * entry.along,
                 rotation_between(Vector3::UnitX(), entry.along)};
  return needle;
}

// On a spot that the needle comes to through air.
void place(Entry& entry, const TetrahedralMesh& mesh, const Vector3& up, Random& random) {
  const Surface surface(mesh);
  for (;;) {
    const Spot spot = pick_spot(mesh, up, random);
    entry.tilt = random.uniform(0, std::numbers::pi / 3);
    const Vector3 about = spot.normal.cross(random.direction()).normalized();
    entry.along = -(rotation_exp(entry.tilt * about) * spot.normal);
    entry.at = spot.at;
    entry.normal = spot.normal;
    entry.element = element_size(mesh, spot.tetrahedron);
    const Vector3 tip = spot.at - entry.gap * entry.along, base = tip - kNeedleLength * entry.along;
    const bool blocked = surface.entry(mesh.nodes, base, tip) || find_tetrahedron(mesh, mesh.nodes, tip) >= 0;
    if (!blocked) return;
  }
}

// Entry::support.
double support_of(const TetrahedralMesh& mesh, const Entry& entry, double radius) {
  constexpr int kPoints = 24;
  const Surface surface(mesh);
  Vector3 across[2];
  perpendicular_basis(entry.normal, across[0], across[1]);
  int on = 0;
  for (int i = 0; i < kPoints; ++i) {
    const double angle = 2 * std::numbers::pi * i / kPoints;
    const Vector3 p = entry.at + radius * (std::cos(angle) * across[0] + std::sin(angle) * across[1]);
    on += (surface.closest(mesh.nodes, p).position - p).norm() < 0.25 * radius;
  }
  return static_cast<double>(on) / kPoints;
}

}  // namespace

Entry random_entry(int number, const std::vector<GmshMesh>& meshes) {
  Random random(static_cast<unsigned>(number) + 1);
  Entry entry;
  entry.number = number;
  Scene& scene = entry.scene;
  scene.name = "entry " + std::to_string(number);
  scene.tissue.rung = pick_rung(number, random);
  const int body = random.index(100);
  if (meshes.empty() || body < 70) {
    entry.body = "block";
    make_block(scene, random);
  } else {
    scene.tissue.gmsh = meshes[static_cast<std::size_t>(random.index(static_cast<int>(meshes.size())))];
    entry.body = std::filesystem::path(scene.tissue.gmsh->file).stem().string();
  }
  scene.tissue.regions.resize(1);

  entry.ratio = log_uniform(random, 0.3, 20);
  entry.speed = log_uniform(random, 5e-3, 0.3);
  scene.rate = std::clamp(entry.speed / kWayOfTick, kLeastRate, kLargestRate);
  const TetrahedralMesh mesh = load_mesh(scene);
  const Vector3 up = entry.body == "block" ? Vector3::UnitZ() : random.direction();
  scene.tissue.fixed = {far_side(mesh, up)};
  place(entry, mesh, up, random);

  Material& material = scene.tissue.regions[0].material;
  Interaction& laws = scene.tissue.regions[0].interaction;
  const double point_force = entry.ratio * entry.element * entry.element;  // over E
  material.young_modulus = std::min(log_uniform(random, 2e3, 50e3), kLargestForce / point_force);
  material.poisson_ratio = random.uniform(0.3, 0.45);
  laws.puncture_force = material.young_modulus * point_force;
  laws.cutting_force = random.uniform(0.1, 0.5) * laws.puncture_force;
  entry.support = support_of(mesh, entry,
                             contact_radius(Indented(material, laws.deep_indentation), kDiameter, laws.puncture_force));
  laws.friction_contact = random.uniform(0, 0.6);
  scene.needles = {make_needle(entry)};
  return entry;
}

namespace {

class EntryRun {
 public:
  explicit EntryRun(const Entry& entry)
      : entry_(entry), simulation_(entry.scene), surface_(simulation_.mesh()), h_(1 / entry.scene.rate) {}

  // Whether there is more to come.
  bool step() {
    way_ += entry_.speed * h_;
    const Pose& start = entry_.scene.needles[0].base;
    simulation_.command(0, {.pose = Pose{start.position + way_ * entry_.along, start.orientation}, .spin = {}});
    outcome_.seconds += processor_time_of([&] { simulation_.step(); });
    note(simulation_.report());
    return outcome_.deepest < kPushedOn && way_ < kWay;
  }

  const EntryOutcome& outcome() const { return outcome_; }

 private:
  void note(const TickReport& report) {
    ++outcome_.ticks;
    outcome_.flags |= report.flags;
    outcome_.inverted_ticks += (report.flags & kElementsInverted) != 0;
    for (const Event& event : report.events) note(event);
    const NeedleReport& needle = report.needles[0];
    outcome_.deepest = std::max(outcome_.deepest, needle.inserted_depth);
    outcome_.ghost_ticks += is_ghost(simulation_, surface_, 0);
  }

  void note(const Event& event) {
    if (event.kind == EventKind::contact && !outcome_.touched) {
      outcome_.touched = true;
      contact_ = way_;
    } else if (event.kind == EventKind::puncture && !outcome_.punctured) {
      outcome_.punctured = true;
      outcome_.puncture_force = event.force;
      outcome_.indentation = way_ - contact_;
    }
    outcome_.released += event.kind == EventKind::release;
    outcome_.found_inside += event.kind == EventKind::intrusion;
  }

  const Entry& entry_;
  Simulation simulation_;
  Surface surface_;
  double h_;            // s
  double way_ = 0;      // m, of the base
  double contact_ = 0;  // m, of the base, at the first contact
  EntryOutcome outcome_;
};

}  // namespace

EntryOutcome run_entry(const Entry& entry) {
  EntryRun run(entry);
  while (run.step()) {
  }
  return run.outcome();
}

}  // namespace acus
