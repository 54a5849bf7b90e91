// SPDX-License-Identifier: GPL-3.0-or-later
// Free longitudinal vibration of a bar of tissue that is held at one end, with lumped masses.
//
// Sources
//   L. Meirovitch, "Fundamentals of Vibrations" (2001), sec. 8.2: w = (pi/2L) sqrt(E/rho) for the first mode.
//   T. J. R. Hughes, "The Finite Element Method" (1987), sec. 7.3.2: in one dimension lumped masses give the frequency
//     (2c/d) sin(pi d/4L) with elements of length d, from below with order two.
//
// Poisson's ratio is zero, so the bar does not narrow and the closed form holds for any section. Tetrahedra share
// masses among the nodes of a section otherwise than they share its force, so the one-dimensional figure is a neighbour
// only.
#include <doctest/doctest.h>

#include <Eigen/SparseCholesky>
#include <numbers>

#include "tests/references/figure.h"
#include "tests/references/static_tissue.h"

namespace acus {
namespace {

constexpr double kPi = std::numbers::pi, kLength = 0.1;  // m

struct Mode {
  double frequency;  // rad/s
  double sine;       // -, cosine of the angle between the mode and the sine of the closed form, in the metric of M
};

Mode first_mode(int cells) {
  Material material = undamped_material();
  material.poisson_ratio = 0;
  const TetrahedralMesh mesh = make_box_mesh({kLength, 0.02, 0.02}, {cells, 2, 2});
  const TissueModel model = bench_tissue(mesh, material, [](const Vector3& p) { return p.x() < -kLength / 2 + 1e-9; });
  const double expected = kPi / (2 * kLength) * std::sqrt(material.young_modulus / material.density);

  Matrix3X forces;
  const ElementRotations rotations = rotations_at(model, mesh.nodes, forces);
  SparseMatrix stiffness, shifted;
  const TissueAssembler assembler(model);
  assembler.assemble(mesh.nodes, rotations, Tangent::rest, {.stiffness = 1}, stiffness);
  assembler.assemble(mesh.nodes, rotations, Tangent::rest, {.mass = -expected * expected, .stiffness = 1}, shifted);

  // Inverse iteration about the closed form, from its sine.
  VectorX mass(model.unknowns()), sine = VectorX::Zero(model.unknowns());
  for (int f = 0; f < model.unknowns() / 3; ++f) {
    const int node = model.free_nodes[static_cast<std::size_t>(f)];
    mass.segment<3>(3 * f).setConstant(model.mass[node]);
    sine[3 * f] = std::sin(kPi * (mesh.nodes(0, node) / kLength + 0.5) / 2);
  }
  sine /= std::sqrt(sine.dot(mass.cwiseProduct(sine)));
  const Eigen::SimplicialLDLT<SparseMatrix, Eigen::Lower> factor(shifted);
  VectorX mode = sine;
  for (int i = 0; i < 8; ++i) {
    mode = factor.solve(VectorX(mass.cwiseProduct(mode)));
    mode /= std::sqrt(mode.dot(mass.cwiseProduct(mode)));
  }
  const VectorX force = stiffness.selfadjointView<Eigen::Lower>() * mode;
  return {std::sqrt(mode.dot(force)) / expected, std::abs(sine.dot(mass.cwiseProduct(mode)))};
}

TEST_CASE("a bar held at one end vibrates at a quarter wave, with order two") {
  double error[2];
  for (int i = 0; i < 2; ++i) {
    const int cells = 8 << i;
    const Mode mode = first_mode(cells);
    CHECK(mode.sine > 0.99);
    const double lumped = 4 * cells / kPi * std::sin(kPi / (4 * cells));
    const std::string name = "bar, first frequency / closed form, " + std::to_string(cells) + " cells";
    CHECK(agrees(name, 1, mode.frequency, 0.006));
    CHECK(agrees(name + ", against lumped masses in one dimension", lumped, mode.frequency, 0.002));
    error[i] = std::abs(mode.frequency - 1);
  }
  CHECK(agrees("bar, order of the frequency in the cells' length", 2, observed_order(error[0], error[1]), 0.2));
}

}  // namespace
}  // namespace acus
