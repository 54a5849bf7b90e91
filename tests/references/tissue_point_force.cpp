// SPDX-License-Identifier: GPL-3.0-or-later
// A point force inside an unbounded body and on a half-space. The exact displacements are prescribed on the faces of
// the cube that are not free, so that the cube is a part of that body, and compared at the nodes at a distance from the
// force.
//
// Sources
//   Kelvin 1848; A. E. H. Love, "A Treatise on the Mathematical Theory of Elasticity" (1927), art. 130.
//   J. Boussinesq 1885; K. L. Johnson, "Contact Mechanics" (1985), eq. 3.17 and 3.18.
//   Order two away from the force though its displacement has no finite energy: J. A. Nitsche, A. H. Schatz, "Interior
//     estimates for Ritz-Galerkin methods", Math. Comp. 28 (1974).
#include <doctest/doctest.h>

#include <numbers>

#include "tests/references/figure.h"
#include "tests/references/static_tissue.h"

namespace acus {
namespace {

constexpr double kPi = std::numbers::pi, kForce = 100;  // N

double shear_modulus(const Material& m) { return m.young_modulus / (2 * (1 + m.poisson_ratio)); }

// Displacement (m) at r from the force.
Vector3 kelvin(const Material& m, const Vector3& force, const Vector3& r) {
  const double nu = m.poisson_ratio, distance = r.norm();
  return ((3 - 4 * nu) * force + r.dot(force) / r.squaredNorm() * r) /
         (16 * kPi * shear_modulus(m) * (1 - nu) * distance);
}

// The half-space z < 0 under a force along -z at the origin.
Vector3 boussinesq(const Material& m, double force, const Vector3& p) {
  const double nu = m.poisson_ratio, depth = -p.z(), distance = p.norm();
  const Vector3 across(p.x(), p.y(), 0);
  const double factor = force / (4 * kPi * shear_modulus(m) * distance);
  const double down = depth * depth / (distance * distance) + 2 * (1 - nu);
  const double out = depth / (distance * distance) - (1 - 2 * nu) / (distance + depth);
  return factor * (out * across - down * Vector3::UnitZ());
}

int node_at(const TetrahedralMesh& mesh, const Vector3& place) {
  Eigen::Index nearest;
  REQUIRE((mesh.nodes.colwise() - place).colwise().norm().minCoeff(&nearest) < 1e-12);
  return static_cast<int>(nearest);
}

// Root mean square error over the free nodes at 0.45 to 0.8 m from the force, relative to the displacement there.
double error_around(const TissueModel& model, const Vector3& place, const Vector3& force, const VectorField& exact) {
  Matrix3X load = Matrix3X::Zero(3, model.nodes());
  load.col(node_at(*model.mesh, place)) = force;
  const Matrix3X x = solve_linear(model, exact, load);
  double error = 0, size = 0;
  for (const int node : model.free_nodes) {
    const Vector3 rest = model.mesh->nodes.col(node);
    const double distance = (rest - place).norm();
    if (distance < 0.45 || distance > 0.8) continue;
    error += (x.col(node) - rest - exact(rest)).squaredNorm();
    size += exact(rest).squaredNorm();
  }
  return std::sqrt(error / size);
}

TEST_CASE("Kelvin: a point force inside, away from it") {
  const Material material = undamped_material();
  const Vector3 force = kForce * Vector3(0.6, 0, 0.8);
  double errors[2];
  for (int i = 0; i < 2; ++i) {
    const TetrahedralMesh mesh = make_cube(8 << i, 0);
    const TissueModel model = bench_tissue(mesh, material, on_cube);
    errors[i] =
        error_around(model, Vector3::Zero(), force, [&](const Vector3& p) { return kelvin(material, force, p); });
  }
  CHECK(agrees("Kelvin, relative error at 0.45 to 0.8 m, elements of 0.125 m", 0, errors[1], 0.025));
  CHECK(agrees("Kelvin, order away from the force", 2, observed_order(errors[0], errors[1]), 0.15));
}

TEST_CASE("Boussinesq: a point force on a half-space, away from it") {
  const Material material = undamped_material();
  const auto held = [](const Vector3& p) { return on_cube(p) && p.z() < 1 - 1e-9; };
  const Vector3 top(0, 0, 1);
  double errors[2];
  for (int i = 0; i < 2; ++i) {
    const TetrahedralMesh mesh = make_cube(8 << i, 0);
    // The rim of the free face is held too.
    const TissueModel model = bench_tissue(
        mesh, material, [&](const Vector3& p) { return held(p) || p.head<2>().cwiseAbs().maxCoeff() > 1 - 1e-9; });
    errors[i] = error_around(model, top, {0, 0, -kForce},
                             [&](const Vector3& p) { return boussinesq(material, kForce, p - top); });
  }
  CHECK(agrees("Boussinesq, relative error at 0.45 to 0.8 m, elements of 0.125 m", 0, errors[1], 0.025));
  CHECK(agrees("Boussinesq, order away from the force", 2, observed_order(errors[0], errors[1]), 0.15));
}

}  // namespace
}  // namespace acus
