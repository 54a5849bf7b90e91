// SPDX-License-Identifier: GPL-3.0-or-later
// The tissue's forces and matrices: patch test, uniform stretch, rigid motions, masses.
#include "server/engine/models/tissue/tissue.h"

#include <doctest/doctest.h>

#include <algorithm>

#include "server/engine/math/random.h"
#include "tests/models/bench_tissue.h"
#include "tests/models/motions.h"
#include "tests/support/dense.h"

namespace acus {
namespace {

constexpr double kHalf = 0.05;

bool on_boundary(const Vector3& p) { return p.cwiseAbs().maxCoeff() > kHalf - 1e-9; }

// A box of 3 x 3 x 3 cells whose inner nodes are moved at random.
TetrahedralMesh irregular_box(unsigned seed) {
  TetrahedralMesh mesh = make_box_mesh(Vector3::Constant(2 * kHalf), {3, 3, 3});
  Random random(seed);
  for (int i = 0; i < mesh.node_count(); ++i)
    if (!on_boundary(mesh.nodes.col(i))) mesh.nodes.col(i) += random.vector(0.004);
  build_topology(mesh);
  return mesh;
}

TEST_CASE("patch test: inside a linearly displaced boundary the equilibrium is linear") {
  const TetrahedralMesh mesh = irregular_box(1);
  const TissueModel model = bench_tissue(mesh, undamped_material(), on_boundary);
  REQUIRE(model.free_nodes.size() == 8);
  Random random(2);
  for (const TissueMatrix matrix : {TissueMatrix::refactorized, TissueMatrix::turned}) {
    for (const double angle : {0.0, 0.3}) {
      const Matrix3 f = rotation_exp(angle * random.direction()).toRotationMatrix() *
                        (Matrix3::Identity() + random.matrix(3, 3, 0.05));
      const Matrix3X linear = f * mesh.nodes;
      TissueState state = make_tissue_state(model);
      for (int i = 0; i < mesh.node_count(); ++i)
        if (on_boundary(mesh.nodes.col(i))) state.x.col(i) = linear.col(i);
      BenchMotion motion(model, 1e3, matrix, 1, 1);  // so long a step that inertia plays no part
      for (int iteration = 0; iteration < 200; ++iteration) {
        motion.begin(state);
        motion.linearize(state);
        motion.correct({});
        motion.commit(state);
        state.v.setZero();
      }
      CHECK((state.x - linear).cwiseAbs().maxCoeff() < 1e-10 * kHalf);
    }
  }
}

TEST_CASE("uniform stretch: the block narrows by Poisson's ratio and carries E times the strain") {
  const TetrahedralMesh mesh = irregular_box(3);
  Material material = undamped_material();
  const TissueModel model = bench_tissue(mesh, material);
  const double strain = 0.1, nu = material.poisson_ratio;
  const Vector3 stretch(1 + strain, 1 - nu * strain, 1 - nu * strain);
  const Matrix3X expected = stretch.asDiagonal() * mesh.nodes;

  // Tractions of E strain on the two end faces, as nodal loads.
  Matrix3X load = Matrix3X::Zero(3, mesh.node_count());
  for (const std::array<int, 3>& face : mesh.surface) {
    const Vector3 a = mesh.nodes.col(face[0]), b = mesh.nodes.col(face[1]), c = mesh.nodes.col(face[2]);
    const Vector3 area = 0.5 * (b - a).cross(c - a);
    for (const int node : face) load(0, node) += material.young_modulus * strain * area.x() / 3;
  }

  Matrix3X forces;
  rotations_at(model, expected, forces);
  const double total = material.young_modulus * strain * 4 * kHalf * kHalf;
  CHECK((forces - load).cwiseAbs().maxCoeff() < 1e-8 * total);

  // And it is found from rest: the loads as rows, a few long ticks of the free block.
  std::vector<TissuePoint> points;
  std::vector<double> lambda;
  std::vector<bool> seen(static_cast<std::size_t>(mesh.node_count()), false);
  for (int t = 0; t < mesh.tetrahedron_count(); ++t)
    for (int k = 0; k < 4; ++k) {
      const int node = mesh.tetrahedra[static_cast<std::size_t>(t)][static_cast<std::size_t>(k)];
      if (seen[static_cast<std::size_t>(node)] || load(0, node) == 0) continue;
      seen[static_cast<std::size_t>(node)] = true;
      points.push_back({{t, Eigen::Vector4d::Unit(k)}, {}, 0});
      lambda.push_back(load(0, node));
    }
  TissueState state = make_tissue_state(model);
  BenchMotion motion(model, 1, TissueMatrix::refactorized, mesh.node_count(), mesh.node_count());
  for (int tick = 0; tick < 30; ++tick) {
    motion.begin(state);
    motion.linearize(state);
    motion.clear_rows();
    for (const TissuePoint& point : points) REQUIRE(motion.add_row(point, Vector3::UnitX()) >= 0);
    motion.correct(lambda);
    motion.commit(state);
    state.v.setZero();
  }
  // The block is free to turn about the load's axis; distances do not see that.
  double error = 0;
  for (int i = 0; i < mesh.node_count(); ++i)
    for (int j = 0; j < i; ++j) {
      const double distance = (state.x.col(i) - state.x.col(j)).norm();
      error = std::max(error, std::abs(distance - (expected.col(i) - expected.col(j)).norm()));
    }
  CHECK(error < 1e-8 * kHalf);
}

TEST_CASE("forces are the gradient of the whole energy, and the exact matrix their derivative") {
  const TetrahedralMesh mesh = irregular_box(4);
  const TissueModel model = bench_tissue(mesh, undamped_material(), [](const Vector3& p) { return p.z() < -0.049; });
  Random random(5);
  Matrix3X x =
      rotation_exp({0.2, 0.5, -0.3}).toRotationMatrix() * mesh.nodes + random.matrix(3, mesh.node_count(), 2e-3);
  Matrix3X forces;
  const ElementRotations rotations = rotations_at(model, x, forces);
  const MatrixX k = dense_matrix(model, x, Tangent::exact, {.stiffness = 1});
  for (int repeat = 0; repeat < 20; ++repeat) {
    const int free = random.index(static_cast<int>(model.free_nodes.size())), axis = random.index(3);
    const int node = model.free_nodes[static_cast<std::size_t>(free)];
    const double step = 1e-6;
    Matrix3X ahead = x, behind = x, forces_ahead, forces_behind;
    ahead(axis, node) += step;
    behind(axis, node) -= step;
    const double slope =
        (elastic_energy(model, ahead, rotations) - elastic_energy(model, behind, rotations)) / (2 * step);
    CHECK(std::abs(slope - forces(axis, node)) < 1e-9 * forces.norm());
    rotations_at(model, ahead, forces_ahead);
    rotations_at(model, behind, forces_behind);
    const Matrix3X difference = (forces_ahead - forces_behind) / (2 * step);
    double error = 0;
    for (std::size_t f = 0; f < model.free_nodes.size(); ++f)
      for (int i = 0; i < 3; ++i)
        error = std::max(
            error, std::abs(difference(i, model.free_nodes[f]) - k(3 * static_cast<int>(f) + i, 3 * free + axis)));
    CHECK(error < 1e-9 * k.cwiseAbs().maxCoeff());
  }
}

// Columns: translations and turns about the origin, of the free nodes at x.
MatrixX rigid_motions(const TissueModel& model, const Matrix3X& x) {
  MatrixX motions(model.unknowns(), 6);
  for (std::size_t f = 0; f < model.free_nodes.size(); ++f) {
    motions.block<3, 3>(3 * static_cast<int>(f), 0).setIdentity();
    motions.block<3, 3>(3 * static_cast<int>(f), 3) = -skew(x.col(model.free_nodes[f]));
  }
  return motions;
}

TEST_CASE("the rest stiffness lets rigid motions pass and resists everything else") {
  const TetrahedralMesh mesh = irregular_box(6);
  const TissueModel model = bench_tissue(mesh, undamped_material());
  const MatrixX k = dense_matrix(model, mesh.nodes, Tangent::rest, {.stiffness = 1});
  const MatrixX motions = rigid_motions(model, mesh.nodes);
  CHECK((k * motions).cwiseAbs().maxCoeff() < 1e-12 * k.cwiseAbs().maxCoeff());
  const VectorX eigenvalues = test::eigenvalues(k);
  CHECK(eigenvalues[0] > -1e-12 * eigenvalues[eigenvalues.size() - 1]);
  CHECK(eigenvalues[5] < 1e-12 * eigenvalues[eigenvalues.size() - 1]);
  CHECK(eigenvalues[6] > 1e-5 * eigenvalues[eigenvalues.size() - 1]);
  for (const Tangent tangent : {Tangent::turned, Tangent::exact})
    CHECK((dense_matrix(model, mesh.nodes, tangent, {.stiffness = 1}) - k).norm() < 1e-11 * k.norm());
}

TEST_CASE("the tangents of the turned block are the turned tangents") {
  const TetrahedralMesh mesh = irregular_box(7);
  const TissueModel model = bench_tissue(mesh, undamped_material());
  const Matrix3 turn = rotation_exp({0.9, -1.4, 0.7}).toRotationMatrix();
  const Matrix3X x = turn * mesh.nodes;
  const MatrixX k = dense_matrix(model, mesh.nodes, Tangent::rest, {.stiffness = 1});
  MatrixX turned = k;
  for (int i = 0; i < model.unknowns(); i += 3)
    for (int j = 0; j < model.unknowns(); j += 3)
      turned.block<3, 3>(i, j) = turn * k.block<3, 3>(i, j) * turn.transpose();
  for (const Tangent tangent : {Tangent::turned, Tangent::exact})
    CHECK((dense_matrix(model, x, tangent, {.stiffness = 1}) - turned).norm() < 1e-11 * k.norm());
  CHECK((dense_matrix(model, x, Tangent::rest, {.stiffness = 1}) - k).norm() == 0);
}

TEST_CASE("masses add up to density times volume, and enter the matrix by their factors") {
  const TetrahedralMesh mesh = irregular_box(8);
  Material material = undamped_material();
  material.density = 1100;
  material.rayleigh_mass = 3;
  material.rayleigh_stiffness = 0.02;
  const TissueModel model = bench_tissue(mesh, material);
  CHECK(model.mass.sum() == doctest::Approx(1100 * 8 * kHalf * kHalf * kHalf).epsilon(1e-12));
  CHECK((model.mass_damping - 3 * model.mass).norm() < 1e-15);
  const MatrixX k = dense_matrix(model, mesh.nodes, Tangent::rest, {.stiffness = 1});
  MatrixX expected = (5 + 0.02 * 7) * k;
  for (int i = 0; i < model.unknowns(); ++i) expected(i, i) += (11 + 3 * 13) * model.mass[i / 3];
  const MatrixX all = dense_matrix(model, mesh.nodes, Tangent::rest,
                                   {.mass = 11, .mass_damping = 13, .stiffness = 5, .stiffness_damping = 7});
  CHECK((all - expected).norm() < 1e-12 * expected.norm());
}

TEST_CASE("regions keep their own stiffness and density") {
  const TetrahedralMesh mesh = make_box_mesh(Vector3::Constant(2 * kHalf), {2, 2, 2});
  Material soft = undamped_material(), hard = soft;
  hard.young_modulus *= 10;
  hard.density *= 2;
  std::vector<int> region(mesh.tetrahedra.size(), 0);
  region[5] = 1;
  const std::vector<Material> materials{soft, hard};
  const TissueModel model = make_tissue_model(
      mesh, region, materials, std::vector<bool>(static_cast<std::size_t>(mesh.node_count()), false), Vector3::Zero());
  CHECK(model.elements[5].law.mu == doctest::Approx(10 * model.elements[4].law.mu));
  CHECK(model.elements[5].law.lambda == doctest::Approx(10 * model.elements[4].law.lambda));
  const double total = 1000 * 8 * kHalf * kHalf * kHalf;
  CHECK(model.mass.sum() == doctest::Approx(total + 1000 * rest_volume(mesh, 5)));
}

}  // namespace
TEST_CASE("the rotation of a node does not depend on the signs of its elements' quaternions") {
  const TetrahedralMesh mesh = make_box_mesh({0.1, 0.1, 0.1}, {2, 2, 2});
  const TissueModel model = bench_tissue(mesh, undamped_material());
  for (const double angle : {0.3, 1.7, 3.0}) {
    const Quaternion turn = rotation_exp(angle * Vector3(1, 2, -2) / 3);
    ElementRotations rotations(model);
    for (std::size_t b = 0; b < rotations.batches.size(); ++b)
      for (int lane = 0; lane < kLanes; ++lane) {
        const double sign = (static_cast<int>(b) + lane) % 3 == 0 ? -1 : 1;
        const double q[4] = {turn.w(), turn.x(), turn.y(), turn.z()};
        for (int i = 0; i < 4; ++i) rotations.batches[b].q[i][lane] = sign * q[i];
      }
    Matrix4X nodes(4, mesh.node_count());
    node_rotations(model, rotations, nodes);
    for (int i = 0; i < mesh.node_count(); ++i) {
      const Quaternion node(nodes(0, i), nodes(1, i), nodes(2, i), nodes(3, i));
      CHECK(node.angularDistance(turn) < 1e-7);
    }
  }
}

}  // namespace acus
