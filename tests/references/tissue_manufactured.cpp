// SPDX-License-Identifier: GPL-3.0-or-later
// Order of convergence in space by the method of manufactured solutions: a smooth displacement is chosen, the load per
// volume that it needs is derived from the equations, and what the elements make of that load is compared with it.
//
// Sources
//   P. J. Roache, "Code verification by the method of manufactured solutions", J. Fluids Eng. 124 (2002).
//   S. C. Brenner, L. R. Scott, "The Mathematical Theory of Finite Element Methods" (2008), Theorems 11.2.16 and
//     11.3.3: linear elements, error of order 1 in the gradient and 2 in the displacement, in the L2 norm.
//
// Meshes are jittered, so that no symmetry makes the elements better than they are. Poisson's ratio 0.3; towards 0.5
// the orders hold but their constants grow (locking).
#include <doctest/doctest.h>

#include <numbers>

#include "tests/references/figure.h"
#include "tests/references/static_tissue.h"
#include "tests/support/dense.h"

namespace acus {
namespace {

// u = sum over waves of a cos(q·X + phase).
struct Wave {
  Vector3 a;  // m
  Vector3 q;  // 1/m
  double phase;
};

class Waves {
 public:
  explicit Waves(double amplitude)
      : waves_{{amplitude * Vector3(1, -0.5, 0.3), {1.1, 0.7, -0.4}, 0.3},
               {amplitude * Vector3(-0.2, 0.8, 0.6), {-0.6, 1.3, 0.9}, 1.1},
               {amplitude * Vector3(0.4, 0.3, -0.9), {0.5, -0.8, 1.4}, 2.0}} {}

  Vector3 displacement(const Vector3& p) const {
    Vector3 u = Vector3::Zero();
    for (const Wave& w : waves_) u += std::cos(w.q.dot(p) + w.phase) * w.a;
    return u;
  }
  Matrix3 gradient(const Vector3& p) const {
    Matrix3 g = Matrix3::Zero();
    for (const Wave& w : waves_) g -= std::sin(w.q.dot(p) + w.phase) * w.a * w.q.transpose();
    return g;
  }
  // -div sigma for Hooke's law and small displacements.
  Vector3 load(const Vector3& p, double mu, double lambda) const {
    Vector3 b = Vector3::Zero();
    for (const Wave& w : waves_)
      b += std::cos(w.q.dot(p) + w.phase) * ((lambda + mu) * w.q.dot(w.a) * w.q + mu * w.q.squaredNorm() * w.a);
    return b;
  }

 private:
  Wave waves_[3];
};

Material stiff_material() {
  Material material = undamped_material();
  material.poisson_ratio = 0.3;
  return material;
}

double shear_modulus(const Material& m) { return m.young_modulus / (2 * (1 + m.poisson_ratio)); }
double lame_modulus(const Material& m) {
  return m.young_modulus * m.poisson_ratio / ((1 + m.poisson_ratio) * (1 - 2 * m.poisson_ratio));
}

void check_orders(const char* name, const FieldErrors& coarse, const FieldErrors& fine) {
  const double u = observed_order(coarse.displacement, fine.displacement);
  const double g = observed_order(coarse.gradient, fine.gradient);
  CHECK(agrees(std::string(name) + ", order of displacement", 2, u, 0.05));
  CHECK(agrees(std::string(name) + ", order of gradient", 1, g, 0.03));
}

TEST_CASE("manufactured solution, small displacements: orders two and one") {
  const Material material = stiff_material();
  const double mu = shear_modulus(material), lambda = lame_modulus(material);
  const Waves waves(0.01);
  const VectorField u = [&](const Vector3& p) { return waves.displacement(p); };
  FieldErrors errors[2];
  for (int i = 0; i < 2; ++i) {
    const TetrahedralMesh mesh = make_cube(6 << i, 0.15);
    const TissueModel model = bench_tissue(mesh, material, on_cube);
    const Matrix3X load = body_load(mesh, [&](const Vector3& p) { return waves.load(p, mu, lambda); });
    errors[i] =
        field_errors(mesh, solve_linear(model, u, load), u, [&](const Vector3& p) { return waves.gradient(p); });
  }
  check_orders("manufactured, linear", errors[0], errors[1]);
}

// P = R (2 mu (S - I) + lambda tr(S - I) I), with the polar decomposition from singular values.
Matrix3 corotational_stress(const Matrix3& f, double mu, double lambda) {
  const test::Polar polar = test::polar_decomposition(f);
  return 2 * mu * (f - polar.rotation) + lambda * (polar.stretches.sum() - 3) * polar.rotation;
}

TEST_CASE("manufactured solution, strains and turns of tenths: orders two and one") {
  const Material material = stiff_material();
  const double mu = shear_modulus(material), lambda = lame_modulus(material);
  const Waves waves(0.12);
  const auto stress = [&](const Vector3& p) {
    return corotational_stress(Matrix3::Identity() + waves.gradient(p), mu, lambda);
  };
  const VectorField minus_divergence = [&](const Vector3& p) {
    constexpr double kStep = 1e-4;  // m
    Vector3 b = Vector3::Zero();
    for (int k = 0; k < 3; ++k)
      b -= (stress(p + kStep * Vector3::Unit(k)) - stress(p - kStep * Vector3::Unit(k))).col(k) / (2 * kStep);
    return b;
  };
  const VectorField u = [&](const Vector3& p) { return waves.displacement(p); };
  FieldErrors errors[2];
  for (int i = 0; i < 2; ++i) {
    const TetrahedralMesh mesh = make_cube(4 << i, 0.15);
    const TissueModel model = bench_tissue(mesh, material, on_cube);
    Matrix3X start = mesh.nodes;
    for (int n = 0; n < mesh.node_count(); ++n) start.col(n) += u(mesh.nodes.col(n));
    const Matrix3X x = solve_corotational(model, start, body_load(mesh, minus_divergence));
    errors[i] = field_errors(mesh, x, u, [&](const Vector3& p) { return waves.gradient(p); });
  }
  check_orders("manufactured, corotational", errors[0], errors[1]);
}

}  // namespace
}  // namespace acus
