// SPDX-License-Identifier: GPL-3.0-or-later
// Rotations of nodes, averaged over several elements.
#include "server/engine/models/element/rotation_grid.h"

#include <doctest/doctest.h>

#include <numbers>

#include "server/engine/math/random.h"
#include "server/engine/math/rotation.h"

namespace acus {
namespace {

constexpr double kCell = 0.01;  // m

TetrahedralMesh bench_mesh() { return make_box_mesh({0.1, 0.1, 0.1}, {10, 10, 10}); }

Eigen::Vector4d numbers(const Quaternion& q) { return {q.w(), q.x(), q.y(), q.z()}; }
Quaternion rotation(const Matrix4X& q, int i) { return {q(0, i), q(1, i), q(2, i), q(3, i)}; }

// Each node turned about z by turn(X).
template <class Turn>
Matrix4X turned(const TetrahedralMesh& mesh, Turn turn) {
  Matrix4X q(4, mesh.node_count());
  for (int i = 0; i < mesh.node_count(); ++i)
    q.col(i) = numbers(rotation_exp(turn(mesh.nodes.col(i)) * Vector3::UnitZ()));
  return q;
}

void smooth(const TetrahedralMesh& mesh, Matrix4X& q) {
  const RotationGrid grid = make_rotation_grid(mesh);
  Matrix4X sums(4, grid.points);
  smooth_rotations(grid, q, sums);
}

}  // namespace

TEST_CASE("the weights of each node sum to one, and the volumes to that of the tissue") {
  const RotationGrid grid = make_rotation_grid(bench_mesh());
  double volume = 0;
  for (const RotationGrid::Node& node : grid.nodes) {
    double sum = 0;
    for (const double weight : node.weights) {
      CHECK(weight >= 0);
      sum += weight;
    }
    CHECK(sum == doctest::Approx(1).epsilon(1e-12));
    for (const int point : node.points) CHECK((point >= 0 && point < grid.points));
    volume += node.volume;
  }
  CHECK(volume == doctest::Approx(1e-3).epsilon(1e-12));
}

TEST_CASE("a rotation of the whole stays as it is, whatever the signs of the quaternions") {
  const TetrahedralMesh mesh = bench_mesh();
  for (const double angle : {0.3, 1.7, 3.1}) {
    CAPTURE(angle);
    const Quaternion turn = rotation_exp(angle * Vector3(1, 2, -2) / 3);
    Matrix4X q(4, mesh.node_count());
    for (int i = 0; i < mesh.node_count(); ++i) q.col(i) = (i % 3 == 0 ? -1 : 1) * numbers(turn);
    smooth(mesh, q);
    for (int i = 0; i < mesh.node_count(); ++i) CHECK(rotation(q, i).angularDistance(turn) < 1e-7);
  }
}

TEST_CASE("what turns to and fro from node to node is averaged out, a bend of the whole stays") {
  const TetrahedralMesh mesh = bench_mesh();
  Matrix4X rough = turned(mesh, [](const Vector3& x) { return std::lround(x.x() / kCell) % 2 == 0 ? 0.2 : -0.2; });
  smooth(mesh, rough);
  Matrix4X bent = turned(mesh, [](const Vector3& x) { return 5 * x.x(); });  // 0.5 rad over the block
  const Matrix4X before = bent;
  smooth(mesh, bent);
  for (int i = 0; i < mesh.node_count(); ++i) {
    CHECK(rotation(rough, i).angularDistance(Quaternion::Identity()) < 0.05);
    CHECK(rotation(bent, i).angularDistance(rotation(before, i)) < 0.13);
  }
}

TEST_CASE("where rotations cancel around a node its own stays, and all stay unit") {
  const TetrahedralMesh mesh = bench_mesh();
  Random random(3);
  Matrix4X q(4, mesh.node_count());
  for (int i = 0; i < mesh.node_count(); ++i)
    q.col(i) = numbers(rotation_exp(random.uniform(0, std::numbers::pi) * random.direction()));
  smooth(mesh, q);
  CHECK(q.allFinite());
  CHECK((q.colwise().norm().array() - 1).abs().maxCoeff() < 1e-12);
}

TEST_CASE("the rotations of a turned mesh are the turned rotations") {
  const TetrahedralMesh mesh = bench_mesh();
  const Quaternion turn = rotation_exp(Vector3(0.7, -1.1, 0.4));
  TetrahedralMesh moved = mesh;
  moved.nodes = turn.toRotationMatrix() * mesh.nodes;
  Random random(5);
  Matrix4X here(4, mesh.node_count()), there = here;
  for (int i = 0; i < mesh.node_count(); ++i) {
    const Quaternion q = rotation_exp(random.uniform(0, 0.5) * random.direction());
    here.col(i) = numbers(q);
    there.col(i) = numbers(turn * q * turn.conjugate());
  }
  smooth(mesh, here);
  smooth(moved, there);
  for (int i = 0; i < mesh.node_count(); ++i)
    CHECK((turn * rotation(here, i) * turn.conjugate()).angularDistance(rotation(there, i)) < 1e-7);
}

TEST_CASE("a mesh without elements has no grid") {
  TetrahedralMesh empty;
  Matrix4X q(4, 0), sums(4, 0);
  const RotationGrid grid = make_rotation_grid(empty);
  CHECK(grid.points == 0);
  smooth_rotations(grid, q, sums);
}

}  // namespace acus
