// SPDX-License-Identifier: GPL-3.0-or-later
// Homogeneous strains of an irregular mesh, as large as they come: every element is strained alike, so forces inside
// vanish and the force on a face is the first Piola-Kirchhoff stress P times its area at rest.
//
// Source: the corotational energy mu |S - I|² + lambda/2 tr(S - I)² of
// server/engine/models/element/corotational_tetrahedron.h, F = R S, also called linear corotational (E. Sifakis, J.
// Barbic, "FEM simulation of 3D deformable solids", SIGGRAPH Courses 2012, sec. 3.4), worked out by hand:
//   hydrostatic, F = s I:                 P = (2 mu + 3 lambda)(s - 1) I = 3 K (s - 1) I
//   confined stretch, F = diag(s, 1, 1):  P_11 = (2 mu + lambda)(s - 1),  P_22 = lambda (s - 1)
//   uniaxial, sides free:                 P_11 = E (s - 1), narrowing by 1 - nu (s - 1)
//   simple shear, F = I + g e1 e2ᵀ:       tr S = 1 + w, w = sqrt(4 + g²), R = [2 g; -g 2]/w in the plane, so that
//                                         P = 2 mu (F - R) + lambda (w - 2) R
// Small strains give Hooke's law. tests/models/tissue.cpp has the patch test with free nodes and a stretch by 10 %.
#include <doctest/doctest.h>

#include "tests/references/figure.h"
#include "tests/references/static_tissue.h"

namespace acus {
namespace {

Material material() {
  Material m = undamped_material();
  m.poisson_ratio = 0.3;
  return m;
}

struct Lame {
  double mu, lambda;
  explicit Lame(const Material& m)
      : mu(m.young_modulus / (2 * (1 + m.poisson_ratio))),
        lambda(m.young_modulus * m.poisson_ratio / ((1 + m.poisson_ratio) * (1 - 2 * m.poisson_ratio))) {}
};

struct Response {
  Matrix3 stress;         // Pa, column k: force on the face along +k over its area at rest
  double largest_inside;  // N, on a node inside the cube
  double energy;          // J
};

Response strain_cube(const Matrix3& f) {
  const TetrahedralMesh mesh = make_cube(4, 0.2);
  const TissueModel model = bench_tissue(mesh, material());
  Matrix3X forces;
  const ElementRotations rotations = rotations_at(model, f * mesh.nodes, forces);
  Response r{Matrix3::Zero(), 0, elastic_energy(model, f * mesh.nodes, rotations)};
  // P over the cube: the forces' moment tensor over the volume, sum of f Xᵀ / V.
  r.stress = forces * mesh.nodes.transpose() / 8;
  for (int i = 0; i < mesh.node_count(); ++i)
    if (!on_cube(mesh.nodes.col(i))) r.largest_inside = std::max(r.largest_inside, forces.col(i).norm());
  return r;
}

void check_response(const std::string& name, const Matrix3& f, const Matrix3& stress, double energy_density) {
  const Response r = strain_cube(f);
  const double size = material().young_modulus * (f - Matrix3::Identity()).norm();
  CHECK(agrees(name + ", stress off / (E strain)", 0, (r.stress - stress).norm() / size, 1e-12));
  CHECK(agrees(name + ", forces inside / (E strain 1 m²)", 0, r.largest_inside / size, 1e-12));
  CHECK(agrees(name + ", energy / (E 1 m³)", 8 * energy_density / material().young_modulus,
               r.energy / material().young_modulus, 1e-12));
}

TEST_CASE("hydrostatic: a cube at half to twice its size bears 3 K times the strain") {
  const Lame m(material());
  for (const double s : {0.5, 0.99, 1.01, 2.0}) {
    const double bulk = m.lambda + 2 * m.mu / 3, e = s - 1;
    check_response("hydrostatic, s = " + std::to_string(s), s * Matrix3::Identity(), 3 * bulk * e * Matrix3::Identity(),
                   4.5 * bulk * e * e);
  }
}

TEST_CASE("confined and uniaxial stretch: Hooke's law in the nominal strain") {
  const Lame m(material());
  const double young = material().young_modulus, nu = material().poisson_ratio;
  for (const double s : {0.4, 0.99, 1.01, 1.8}) {
    const double e = s - 1;
    const std::string at = ", s = " + std::to_string(s);
    const Vector3 confined(2 * m.mu + m.lambda, m.lambda, m.lambda);
    check_response("confined stretch" + at, Vector3(s, 1, 1).asDiagonal(), Matrix3((e * confined).asDiagonal()),
                   (m.mu + m.lambda / 2) * e * e);
    check_response("uniaxial stretch" + at, Vector3(s, 1 - nu * e, 1 - nu * e).asDiagonal(),
                   Matrix3(Vector3(young * e, 0, 0).asDiagonal()), young * e * e / 2);
  }
}

TEST_CASE("simple shear to 63 degrees: the closed form of the corotational law") {
  const Lame m(material());
  for (const double g : {0.001, 0.1, 0.5, 1.0, 2.0}) {
    const double w = std::sqrt(4 + g * g);
    Matrix3 f = Matrix3::Identity(), r = Matrix3::Identity();
    f(0, 1) = g;
    r.topLeftCorner<2, 2>() << 2 / w, g / w, -g / w, 2 / w;
    // |S - I| = |F - R|.
    const double density = m.mu * (f - r).squaredNorm() + m.lambda / 2 * (w - 2) * (w - 2);
    check_response("simple shear, " + std::to_string(g), f, 2 * m.mu * (f - r) + m.lambda * (w - 2) * r, density);
  }
}

}  // namespace
}  // namespace acus
