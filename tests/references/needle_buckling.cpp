// SPDX-License-Identifier: GPL-3.0-or-later
// A needle that is pushed against a surface which it cannot enter buckles, and bears little more from then on.
//
// Sources
//   S. P. Timoshenko, J. M. Gere, "Theory of Elastic Stability" (1961), sec. 2.1 and 2.3
//   The same, sec. 2.7: the cantilever beyond buckling
//
// At the limit P = pi² EI/(K L)², K = 2 for a tip that slides (clamped - free), K = 0.699 for one that sticks (clamped
// - pinned: tan kL = kL, kL = 4.4934). Beyond it, with the tip's slope a and p = sin(a/2), the cantilever bears P =
// K(p)² EI/L² when its ends have come closer by 2 L (1 - E(p)/K(p)); K(p), E(p) are complete elliptic integrals. The
// pinned needle beyond buckling is the elastica of the same section with a force across at its end; shooting.
//
// The needle has an imperfection, a curvature of 1e-3/m; the load at a given approach hardly depends on it. It shortens
// by P L/EA besides, which is added to the approach.
#include <cmath>
#include <numbers>

#include "server/engine/models/unresolved/dimple.h"
#include "tests/references/figure.h"
#include "tests/references/rigid_ground.h"
#include "tests/support/dense.h"

namespace acus::test {
namespace {

constexpr double kPi = std::numbers::pi;

Scene bone_scene(double friction) {
  Scene scene = rigid_ground();
  Needle& needle = scene.needles[0];
  needle.beams = 40;
  needle.curvature = 1e-3;
  Interaction& law = scene.tissue.regions[0].interaction;
  law.puncture_force = kInfinity;
  law.friction_contact = friction;
  return scene;
}

// EI/L² (N) and the needle's length (m).
struct Column {
  double unit_load, length, axial;
  explicit Column(const Needle& n)
      : unit_load(bending_stiffness(n) / (n.length * n.length)), length(n.length), axial(axial_stiffness(n)) {}

  // How far the base goes from where the tip touches (m).
  double approach(double of_ends, double load) const { return of_ends + load * length / axial; }
};

// Pushes on to an approach and waits; the force along the axis (N).
double load_at(Bench& bench, double& pushed, double approach) {
  const double gap = 1e-4;
  bench.push(0, approach + gap - pushed, 0.02);
  pushed = approach + gap;
  bench.wait(0.6);
  return bench.resistance();
}

TEST_CASE("a needle whose tip slides buckles at pi² EI/4L² and follows the elastica from there") {
  const Scene scene = bone_scene(0);
  const Column column(scene.needles[0]);
  Bench bench(scene);
  double pushed = 0;
  for (const double degrees : {10.0, 20.0, 40.0, 60.0}) {
    const double p = std::sin(degrees / 2 * kPi / 180), K = std::comp_ellint_1(p), E = std::comp_ellint_2(p);
    const double load = K * K * column.unit_load, euler = kPi * kPi / 4 * column.unit_load;
    const double found = load_at(bench, pushed, column.approach(2 * column.length * (1 - E / K), load));
    const std::string name = "buckling, sliding tip, slope " + std::to_string(static_cast<int>(degrees)) + "°, P/P_E";
    CHECK(agrees(name, load / euler, found / euler, 0.001 * load / euler));
  }
  CHECK(bench.finite());
  CHECK(bench.needle().phase == Phase::contact);
  // Also where ticks are limited in their step (kStepLimited), as when the needle gives way. The bone's nodes are fixed:
  // they lack the mesh's part of the dimple.
  const Region& bone = scene.tissue.regions[0];
  const Indented tissue(bone.material, bone.interaction.deep_indentation);
  const double depth = -bench.needle().tip_position.z(), force = bench.needle().tip_force.norm();
  CHECK(depth > 0);
  CHECK(dimple_force(tissue, scene.needles[0].outer_diameter, depth) < force);
}

// The elastica of unit length, clamped at s = 0 along x, under the force (-load, side) at its end:
// theta' = m, m' = -(load sin(theta) + side cos(theta)).
struct Pinned {
  double load = 0, side = 0, moment = 0;  // of EI/L², EI/L² and, at the clamp, EI/L

  // y(1), theta'(1) and the approach of the ends, 1 - x(1).
  Vector3 ends() const {
    constexpr int kSteps = 400;
    constexpr double h = 1.0 / kSteps;
    Eigen::Vector4d s(0, 0, 0, moment);  // x, y, theta, m
    const auto slope = [this](const Eigen::Vector4d& at) {
      const double sine = std::sin(at[2]), cosine = std::cos(at[2]);
      return Eigen::Vector4d(cosine, sine, at[3], -(load * sine + side * cosine));
    };
    for (int i = 0; i < kSteps; ++i) {
      const Eigen::Vector4d k1 = slope(s), k2 = slope(s + h / 2 * k1), k3 = slope(s + h / 2 * k2),
                            k4 = slope(s + h * k3);
      s += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
    }
    return {s[1], s[3], 1 - s[0]};
  }

  // The one with a given approach of its ends, by Newton's method from the buckling mode.
  static Pinned at(double approach) {
    constexpr double kRoot = 4.493409457909064;  // tan k = k
    // Small deflections: y = c (k (1 - x) - k cos(kx) + sin(kx)), approach = 1/2 of the integral of y'² = c² k⁴/4.
    const double c = 2 * std::sqrt(approach) / (kRoot * kRoot);
    Vector3 q(kRoot * kRoot, c * kRoot * kRoot * kRoot, c * kRoot * kRoot * kRoot);
    Pinned column;
    const auto residual = [&](const Vector3& at) {
      column = {at[0], -at[1], at[2]};
      return Vector3(column.ends() - Vector3(0, 0, approach));
    };
    for (int i = 0; i < 20; ++i) {
      const Vector3 r = residual(q);
      Matrix3 slope;
      for (int k = 0; k < 3; ++k) slope.col(k) = (residual(q + 1e-6 * Vector3::Unit(k)) - r) / 1e-6;
      q -= test::solve_dense(slope, r);
    }
    REQUIRE(residual(q).norm() < 1e-9);
    return column;
  }
};

TEST_CASE("a needle whose tip sticks buckles at 20.19 EI/L² and follows the elastica from there") {
  CHECK(agrees("buckling, elastica by shooting at small deflection, P L²/EI", 20.1907, Pinned::at(1e-5).load, 3e-4));
  const Scene scene = bone_scene(10);
  const Column column(scene.needles[0]);
  Bench bench(scene);
  double pushed = 0;
  for (const double approach : {0.005, 0.02, 0.05, 0.1}) {
    const double load = Pinned::at(approach).load * column.unit_load, euler = 20.1907 * column.unit_load;
    const double found = load_at(bench, pushed, column.approach(approach * column.length, load));
    CHECK(agrees("buckling, sticking tip, ends closer by " + std::to_string(approach) + " L, P/P_E", load / euler,
                 found / euler, 0.005 * load / euler));
  }
  CHECK(bench.finite());
  CHECK(bench.needle().phase == Phase::contact);
}

}  // namespace
}  // namespace acus::test
