// SPDX-License-Identifier: GPL-3.0-or-later
// Element `nodal_pressure`: its forces against its energy, its matrices against its forces, what it shares with the
// linear element, and that it moves where that one locks.
#include "server/engine/models/element/nodal_pressure.h"

#include <doctest/doctest.h>

#include <Eigen/SparseCholesky>
#include <cmath>
#include <numbers>

#include "server/engine/math/random.h"
#include "tests/models/bench_tissue.h"
#include "tests/models/motions.h"
#include "tests/support/dense.h"

namespace acus {
namespace {

constexpr double kHalf = 0.05;

bool on_boundary(const Vector3& p) { return p.cwiseAbs().maxCoeff() > kHalf - 1e-9; }
bool at_bottom(const Vector3& p) { return p.z() < -kHalf + 1e-9; }

// A box whose inner nodes are moved at random by up to `share` of a cell.
TetrahedralMesh irregular_box(int cells, double share, unsigned seed) {
  TetrahedralMesh mesh = make_box_mesh(Vector3::Constant(2 * kHalf), {cells, cells, cells});
  Random random(seed);
  for (int i = 0; i < mesh.node_count(); ++i)
    if (!on_boundary(mesh.nodes.col(i))) mesh.nodes.col(i) += random.vector(share * 2 * kHalf / cells);
  build_topology(mesh);
  return mesh;
}

Material soft_material() {
  Material material = undamped_material();
  material.poisson_ratio = 0.495;
  return material;
}

// Two materials: the tetrahedra above the middle are stiffer, denser, more damped and nearly as incompressible.
struct TwoRegions {
  TetrahedralMesh mesh = irregular_box(4, 0, 1);
  std::vector<int> region;
  TissueModel nodal, linear;

  explicit TwoRegions(const std::function<bool(const Vector3&)>& is_fixed) {
    std::vector<Material> materials{soft_material(), soft_material()};
    materials[0].rayleigh_stiffness = 0.01;
    materials[1].rayleigh_stiffness = 0.03;
    materials[1].young_modulus *= 20;
    materials[1].poisson_ratio = 0.45;
    std::vector<bool> fixed;
    for (int i = 0; i < mesh.node_count(); ++i) fixed.push_back(is_fixed(mesh.nodes.col(i)));
    for (int t = 0; t < mesh.tetrahedron_count(); ++t) {
      const Vector3 middle = material_position(mesh, mesh.nodes, {t, Eigen::Vector4d::Constant(0.25)});
      region.push_back(middle.z() > 0 ? 1 : 0);
    }
    const auto model = [&](TissueElement element) {
      return make_tissue_model(mesh, region, materials, fixed, {0, 0, -2}, element);
    };
    nodal = model(TissueElement::nodal_pressure);
    linear = model(TissueElement::linear);
  }
  TwoRegions(const TwoRegions&) = delete;

  // Turned as a whole, strained at random.
  Matrix3X deformed(unsigned seed) const {
    return rotation_exp({0.2, 0.5, -0.3}).toRotationMatrix() *
           (mesh.nodes + Matrix3X(Random(seed).matrix(3, mesh.node_count(), 2e-3)));
  }
};

bool nowhere(const Vector3&) { return false; }

TEST_CASE("nodal pressure: forces are the gradient of the energy, and the exact matrix their derivative") {
  const TwoRegions bench(at_bottom);
  const TissueModel& model = bench.nodal;
  const Matrix3X x = bench.deformed(2);
  Matrix3X forces;
  const ElementRotations rotations = rotations_at(model, x, forces);
  const MatrixX k = dense_matrix(model, x, Tangent::exact, {.stiffness = 1});
  Random random(3);
  constexpr double kProbe = 1e-6;  // m
  for (int repeat = 0; repeat < 20; ++repeat) {
    const int free = random.index(static_cast<int>(model.free_nodes.size())), axis = random.index(3);
    const int node = model.free_nodes[static_cast<std::size_t>(free)];
    Matrix3X ahead = x, behind = x, forces_ahead, forces_behind;
    ahead(axis, node) += kProbe;
    behind(axis, node) -= kProbe;
    const double slope =
        (elastic_energy(model, ahead, rotations) - elastic_energy(model, behind, rotations)) / (2 * kProbe);
    CHECK(std::abs(slope - forces(axis, node)) < 1e-9 * forces.norm());
    rotations_at(model, ahead, forces_ahead);
    rotations_at(model, behind, forces_behind);
    double error = 0;
    for (std::size_t f = 0; f < model.free_nodes.size(); ++f)
      for (int i = 0; i < 3; ++i) {
        const int other = model.free_nodes[f];
        const double difference = (forces_ahead(i, other) - forces_behind(i, other)) / (2 * kProbe);
        error = std::max(error, std::abs(difference - k(3 * static_cast<int>(f) + i, 3 * free + axis)));
      }
    CHECK(error < 1e-9 * k.cwiseAbs().maxCoeff());
  }
}

TEST_CASE("nodal pressure: elements are filled up in vectors of eight whatever their number") {
  for (const int cells : {1, 2, 3}) {  // 6, 48 and 162 elements
    const TetrahedralMesh mesh = make_box_mesh({2 * kHalf, kHalf, kHalf}, {cells, 1, 1});
    const TissueModel model =
        bench_tissue(mesh, soft_material(), nullptr, Vector3::Zero(), TissueElement::nodal_pressure);
    CHECK(model.pressure.volume.sum() == doctest::Approx(2 * kHalf * kHalf * kHalf).epsilon(1e-9).scale(0));
    Matrix3X forces, moved = mesh.nodes + Matrix3X(Random(4).matrix(3, mesh.node_count(), 1e-7));
    rotations_at(model, moved, forces);
    const Matrix3X displacement = moved - mesh.nodes;
    const VectorX expected = dense_matrix(model, mesh.nodes, Tangent::rest, {.stiffness = 1}) *
                             Eigen::Map<const VectorX>(displacement.data(), displacement.size());
    CHECK((Eigen::Map<const VectorX>(forces.data(), forces.size()) - expected).norm() < 1e-4 * expected.norm());
  }
}

TEST_CASE("nodal pressure: a displacement that is linear in each region is answered as by linear elements") {
  const TwoRegions bench(nowhere);
  Random random(5);
  for (int repeat = 0; repeat < 5; ++repeat) {
    // Above the border the strain steps by a shear along it and a stretch across it.
    const Matrix3 lower = random.rotation() * (Matrix3::Identity() + random.matrix(3, 3, 0.1));
    const Vector3 step = random.vector(0.1);
    Matrix3X x = lower * bench.mesh.nodes;
    for (int i = 0; i < bench.mesh.node_count(); ++i) x.col(i) += std::max(0.0, bench.mesh.nodes(2, i)) * step;
    Matrix3X nodal_forces, linear_forces;
    const ElementRotations rotations = rotations_at(bench.nodal, x, nodal_forces);
    rotations_at(bench.linear, x, linear_forces);
    CHECK((nodal_forces - linear_forces).norm() < 1e-10 * linear_forces.norm());
    CHECK(elastic_energy(bench.nodal, x, rotations) ==
          doctest::Approx(elastic_energy(bench.linear, x, rotations)).epsilon(1e-12));
  }
}

TEST_CASE("nodal pressure: the energy is never above that of linear elements") {
  const TwoRegions bench(nowhere);
  for (unsigned seed = 0; seed < 5; ++seed) {
    const Matrix3X x = bench.deformed(seed);
    Matrix3X forces;
    const ElementRotations rotations = rotations_at(bench.linear, x, forces);
    const double nodal = elastic_energy(bench.nodal, x, rotations);
    CHECK(nodal > 0);
    CHECK(nodal < elastic_energy(bench.linear, x, rotations));
  }
}

TEST_CASE("nodal pressure: forces balance, and their moments") {
  const TwoRegions bench(nowhere);
  const Matrix3X x = bench.deformed(6);
  Matrix3X forces;
  rotations_at(bench.nodal, x, forces);
  Vector3 moment = Vector3::Zero();
  for (int i = 0; i < bench.mesh.node_count(); ++i) moment += Vector3(x.col(i)).cross(Vector3(forces.col(i)));
  CHECK(forces.rowwise().sum().norm() < 1e-12 * forces.norm());
  CHECK(moment.norm() < 1e-10 * kHalf * forces.norm());
}

TEST_CASE("nodal pressure: below a Poisson's ratio of 1/4 there is nothing to average") {
  const TetrahedralMesh mesh = irregular_box(3, 0.1, 7);
  Material material = undamped_material();
  const auto patches = [&](double poisson_ratio) {
    material.poisson_ratio = poisson_ratio;
    return bench_tissue(mesh, material, nullptr, Vector3::Zero(), TissueElement::nodal_pressure).pressure.patches();
  };
  CHECK(patches(0) == 0);
  CHECK(patches(0.24) == 0);
  CHECK(patches(0.26) == mesh.node_count());
}

TEST_CASE("nodal pressure: the rest stiffness lets rigid motions pass and resists everything else") {
  const TetrahedralMesh mesh = irregular_box(3, 0.1, 8);
  const TissueModel model =
      bench_tissue(mesh, soft_material(), nullptr, Vector3::Zero(), TissueElement::nodal_pressure);
  const MatrixX k = dense_matrix(model, mesh.nodes, Tangent::rest, {.stiffness = 1});
  MatrixX motions(model.unknowns(), 6);
  for (int i = 0; i < mesh.node_count(); ++i) {
    motions.block<3, 3>(3 * i, 0).setIdentity();
    motions.block<3, 3>(3 * i, 3) = -skew(mesh.nodes.col(i));
  }
  CHECK((k * motions).cwiseAbs().maxCoeff() < 1e-12 * k.cwiseAbs().maxCoeff());

  // Besides, no displacement is much softer than the softest of a material that does not lock.
  Material compressible = soft_material();
  compressible.poisson_ratio = 0;
  compressible.young_modulus = 2 * model.elements[0].law.mu;
  const MatrixX shear_only =
      dense_matrix(bench_tissue(mesh, compressible), mesh.nodes, Tangent::rest, {.stiffness = 1});
  const VectorX eigenvalues = test::eigenvalues(k);
  const VectorX reference = test::eigenvalues(shear_only);
  CHECK(eigenvalues[5] < 1e-12 * eigenvalues[eigenvalues.size() - 1]);
  CHECK(eigenvalues[6] > reference[6]);

  for (const Tangent tangent : {Tangent::turned, Tangent::exact})
    CHECK((dense_matrix(model, mesh.nodes, tangent, {.stiffness = 1}) - k).norm() < 1e-11 * k.norm());
  const Matrix3 turn = rotation_exp({0.9, -1.4, 0.7}).toRotationMatrix();
  MatrixX turned = k;
  for (int i = 0; i < model.unknowns(); i += 3)
    for (int j = 0; j < model.unknowns(); j += 3)
      turned.block<3, 3>(i, j) = turn * k.block<3, 3>(i, j) * turn.transpose();
  for (const Tangent tangent : {Tangent::turned, Tangent::exact})
    CHECK((dense_matrix(model, turn * mesh.nodes, tangent, {.stiffness = 1}) - turned).norm() < 1e-11 * k.norm());
}

TEST_CASE("nodal pressure: damping forces and those of the rest stiffness are their matrices' products") {
  const TwoRegions bench(nowhere);
  const Matrix3X x = bench.deformed(9), v = Random(10).matrix(3, bench.mesh.node_count());
  Matrix3X forces;
  ElementRotations rotations = rotations_at(bench.nodal, x, forces);
  ElementScratch scratch(bench.nodal);
  damping_forces(bench.nodal, v, rotations, scratch, forces);
  const VectorX damped = dense_matrix(bench.nodal, x, Tangent::turned, {.stiffness_damping = 1}) *
                         Eigen::Map<const VectorX>(v.data(), v.size());
  CHECK((Eigen::Map<const VectorX>(forces.data(), forces.size()) - damped).norm() < 1e-12 * damped.norm());

  Matrix3X displacement;
  RestStiffness(bench.nodal).forces(x, displacement, forces);
  const VectorX elastic = dense_matrix(bench.nodal, x, Tangent::rest, {.stiffness = 1}) *
                          Eigen::Map<const VectorX>(displacement.data(), displacement.size());
  CHECK((Eigen::Map<const VectorX>(forces.data(), forces.size()) - elastic).norm() < 1e-12 * elastic.norm());
}

TEST_CASE("nodal pressure: patch test") {
  const TetrahedralMesh mesh = irregular_box(3, 0.12, 11);
  const TissueModel model =
      bench_tissue(mesh, soft_material(), on_boundary, Vector3::Zero(), TissueElement::nodal_pressure);
  Random random(12);
  for (const TissueMatrix matrix : {TissueMatrix::refactorized, TissueMatrix::turned}) {
    const Matrix3 f =
        rotation_exp(0.3 * random.direction()).toRotationMatrix() * (Matrix3::Identity() + random.matrix(3, 3, 0.01));
    const Matrix3X linear = f * mesh.nodes;
    TissueState state = make_tissue_state(model);
    for (int i = 0; i < mesh.node_count(); ++i)
      if (on_boundary(mesh.nodes.col(i))) state.x.col(i) = linear.col(i);
    BenchMotion motion(model, 1e3, matrix, 1, 1);  // so long a step that inertia plays no part
    for (int iteration = 0; iteration < 100; ++iteration) {
      motion.begin(state);
      motion.linearize(state);
      motion.correct({});
      motion.commit(state);
      state.v.setZero();
    }
    CHECK((state.x - linear).cwiseAbs().maxCoeff() < 1e-10 * kHalf);
  }
}

TEST_CASE("nodal pressure: the rungs come to one another, and supports carry what they must") {
  const TwoRegions bench(at_bottom);
  constexpr double kStep = 2e-3;
  Matrix3X end[2];
  for (int m = 0; m < 2; ++m) {
    BenchMotion motion(bench.nodal, kStep, m == 0 ? TissueMatrix::turned : TissueMatrix::refactorized, 1, 8);
    TissueState state = make_tissue_state(bench.nodal);
    for (int i = 0; i < bench.mesh.node_count(); ++i) state.x(0, i) += 2 * std::pow(state.x(2, i) + kHalf, 2);
    for (int tick = 0; tick < 3; ++tick) {
      motion.begin(state);
      for (int iteration = 0; iteration < 30; ++iteration) {
        motion.linearize(state);
        if (iteration == 0 && tick > 0) {  // balance() speaks of the tick before
          const TissueBalance& b = motion.balance();
          CHECK((b.support + b.applied - b.inertia).norm() < 1e-8 * b.support.norm());
        }
        motion.clear_rows();
        motion.correct({});
      }
      motion.commit(state);
    }
    end[m] = state.x;
  }
  CHECK((end[0] - end[1]).cwiseAbs().maxCoeff() < 1e-9 * (end[1] - bench.mesh.nodes).cwiseAbs().maxCoeff());
}

TEST_CASE("nodal pressure: at rest supports carry the weight with every matrix" * doctest::test_suite("gate")) {
  const TwoRegions bench(at_bottom);
  for (const TissueMatrix matrix : {TissueMatrix::constant, TissueMatrix::turned, TissueMatrix::refactorized}) {
    BenchMotion motion(bench.nodal, 0.05, matrix, 1, 8);
    TissueState state = make_tissue_state(bench.nodal);
    for (int tick = 0; tick < 150; ++tick) {
      motion.begin(state);
      motion.linearize(state);
      motion.clear_rows();
      motion.correct({});
      motion.commit(state);
    }
    const TissueBalance& b = motion.balance();
    CHECK((b.support + b.applied).norm() < 1e-9 * b.applied.norm());
  }
}

// A vortex in a closed box of edge L: u = (dpsi/dy, -dpsi/dx, 0) L with psi = sin²(kx) sin²(ky) sin²(kz), k = pi/L. It
// has no change of volume anywhere, so that the load that holds it, -mu laplace(u), does not depend on lambda.
struct Vortex {
  static constexpr double k = std::numbers::pi / (2 * kHalf);

  // The integral of -u laplace(u): 15/16 L⁵ k⁴.
  static double work_per_mu() { return 30 * std::pow(kHalf, 5) * std::pow(k, 4); }

  static double square(double t) { return std::pow(std::sin(k * t), 2); }
  static double slope(double t) { return k * std::sin(2 * k * t); }
  static double bend(double t) { return 2 * k * k * std::cos(2 * k * t); }

  static Vector3 load_per_mu(const Vector3& centred) {
    const auto laplace = [](double x, double y, double z) {  // of square(x) slope(y) square(z)
      return bend(x) * slope(y) * square(z) - 4 * k * k * square(x) * slope(y) * square(z) +
             square(x) * slope(y) * bend(z);
    };
    const Vector3 p = centred.array() + kHalf;
    return -2 * kHalf * Vector3(laplace(p.x(), p.y(), p.z()), -laplace(p.y(), p.x(), p.z()), 0);
  }
};

// The work of the vortex's load on the displacement that it causes, over that on the exact one: 1 on a fine mesh.
double vortex_work(const TetrahedralMesh& mesh, const TissueModel& model) {
  ElementRotations unturned(model);
  SparseMatrix lower;
  TissueAssembler(model).assemble(mesh.nodes, unturned, Tangent::rest, {.stiffness = 1}, lower);
  VectorX load = VectorX::Zero(model.unknowns());
  const double exact = model.elements[0].law.mu * Vortex::work_per_mu();
  for (int t = 0; t < mesh.tetrahedron_count(); ++t)
    for (int q = 0; q < 4; ++q) {  // Gauss points of degree two
      Eigen::Vector4d weights = Eigen::Vector4d::Constant((5 - std::sqrt(5.0)) / 20);
      weights[q] = (5 + 3 * std::sqrt(5.0)) / 20;
      const Vector3 point = material_position(mesh, mesh.nodes, {t, weights});
      const Vector3 force =
          model.elements[static_cast<std::size_t>(t)].law.mu * rest_volume(mesh, t) / 4 * Vortex::load_per_mu(point);
      for (int k = 0; k < 4; ++k) {
        const int node = mesh.tetrahedra[static_cast<std::size_t>(t)][static_cast<std::size_t>(k)];
        const int free = model.free_index[static_cast<std::size_t>(node)];
        if (free >= 0) load.segment<3>(3 * free) += weights[k] * force;
      }
    }
  const VectorX u = Eigen::SimplicialLLT<SparseMatrix>(lower).solve(load);
  return load.dot(u) / exact;
}

TEST_CASE("nodal pressure: a vortex in a closed box turns at any Poisson's ratio; with linear elements it locks") {
  double work[2][2];
  for (const int cells : {6, 9}) {
    const TetrahedralMesh mesh = irregular_box(cells, 0.15, 13);
    Material material = soft_material();
    material.poisson_ratio = 0.4999;
    double* at = work[cells == 9];
    at[0] = vortex_work(mesh, bench_tissue(mesh, material, on_boundary));
    at[1] =
        vortex_work(mesh, bench_tissue(mesh, material, on_boundary, Vector3::Zero(), TissueElement::nodal_pressure));
    MESSAGE(cells << " cells: linear " << at[0] << ", nodal_pressure " << at[1]);
  }
  CHECK(work[0][0] < 0.1);
  CHECK(work[1][0] < 0.2);
  CHECK(work[0][1] > 0.5);
  CHECK(work[1][1] < 1);
  // The error falls with the square of the element size.
  CHECK(std::log((1 - work[0][1]) / (1 - work[1][1])) / std::log(1.5) == doctest::Approx(2).epsilon(0.015).scale(0));
}

}  // namespace
}  // namespace acus
