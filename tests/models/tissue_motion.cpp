// SPDX-License-Identifier: GPL-3.0-or-later
// The tissue's tick: rest under gravity, momentum, and rows against the dense inverse, for both matrices.
#include "tests/models/motions.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "server/engine/math/random.h"
#include "server/engine/models/geometry/surface.h"
#include "tests/models/bench_tissue.h"
#include "tests/support/dense.h"

namespace acus {
namespace {

constexpr double kHeight = 0.1;
constexpr TissueMatrix kMatrices[] = {TissueMatrix::turned, TissueMatrix::refactorized, TissueMatrix::constant};

// What L as rounded may differ by, of the largest number in question.
double rounding(const TissueMotion& motion) { return motion.precision() == Precision::double_precision ? 1e-11 : 1e-6; }

// W_t and the free displacements of the rows of a tick.
struct Compliance {
  MatrixX W;
  std::vector<double> delta;

  Compliance(TissueMotion& motion, int rows)
      : W(MatrixX::Constant(rows, rows, std::nan(""))), delta(static_cast<std::size_t>(rows), 0.0) {
    motion.set_compliance(W, delta);
    W = MatrixX(W.selfadjointView<Eigen::Lower>());
  }
};

bool at_bottom(const Vector3& p) { return p.z() < -kHeight / 2 + 1e-9; }

TetrahedralMesh column() { return make_box_mesh({0.05, 0.05, kHeight}, {2, 2, 4}); }

Material damped_material(double poisson_ratio) {
  Material material = undamped_material();
  material.poisson_ratio = poisson_ratio;
  material.rayleigh_mass = 20;
  material.rayleigh_stiffness = 0.01;
  return material;
}

void tick(TissueMotion& motion, TissueState& state, int iterations = 1) {
  motion.begin(state);
  for (int i = 0; i < iterations; ++i) {
    motion.linearize(state);
    motion.clear_rows();
    motion.correct({});
  }
  motion.commit(state);
}

MaterialPoint random_point(const TetrahedralMesh& mesh, Random& random) {
  Eigen::Vector4d weights;
  for (int k = 0; k < 4; ++k) weights[k] = random.uniform(0.05, 1);
  return {random.index(mesh.tetrahedron_count()), weights / weights.sum()};
}

TEST_CASE("a column at rest stands on its supports with its weight, and has sunk as far as a rod" *
          doctest::test_suite("gate")) {
  const TetrahedralMesh mesh = column();
  const Vector3 gravity(0, 0, -1);
  const Material material = damped_material(0);  // without narrowing the column is a rod
  const TissueModel model = bench_tissue(mesh, material, at_bottom, gravity);
  for (const TissueMatrix matrix : kMatrices) {
    BenchMotion motion(model, 5e-3, matrix, 1, 1);
    TissueState state = make_tissue_state(model);
    for (int i = 0; i < 1500; ++i) tick(motion, state);
    double free_mass = 0, sunk = 0;
    int top = 0;
    for (const int node : model.free_nodes) {
      free_mass += model.mass[node];
      if (mesh.nodes(2, node) < kHeight / 2 - 1e-9) continue;
      sunk += mesh.nodes(2, node) - state.x(2, node);
      ++top;
    }
    CHECK((motion.balance().applied - free_mass * gravity).norm() < 1e-12 * free_mass);
    CHECK((motion.balance().support + free_mass * gravity).norm() < 1e-8 * free_mass);
    CHECK(motion.balance().inertia.norm() < 1e-8 * free_mass);
    const double rod = material.density * kHeight * kHeight / (2 * material.young_modulus);
    CHECK(sunk / top == doctest::Approx(rod).epsilon(0.01).scale(0));
  }
}

TEST_CASE("turned and refactorized come to the same rest" * doctest::test_suite("gate")) {
  const TetrahedralMesh mesh = column();
  const TissueModel model = bench_tissue(mesh, damped_material(0.4), at_bottom, {3, 0, -5});
  Matrix3X rest[2];
  for (int m = 0; m < 2; ++m) {
    BenchMotion motion(model, 5e-3, kMatrices[m], 1, 1);
    TissueState state = make_tissue_state(model);
    for (int i = 0; i < 2500; ++i) tick(motion, state);
    rest[m] = state.x;
  }
  CHECK((rest[0] - rest[1]).cwiseAbs().maxCoeff() < 1e-9);
  CHECK((rest[0] - mesh.nodes).cwiseAbs().maxCoeff() > 5e-3);
}

TEST_CASE("undisturbed tissue stays at its rest shape but for rounding") {
  const TetrahedralMesh mesh = column();
  const TissueModel model = bench_tissue(mesh, damped_material(0.4), at_bottom);
  for (const TissueMatrix matrix : kMatrices) {
    BenchMotion motion(model, 1e-3, matrix, 1, 1);
    TissueState state = make_tissue_state(model);
    for (int i = 0; i < 200; ++i) tick(motion, state);
    CHECK((state.x - mesh.nodes).cwiseAbs().maxCoeff() < 1e-15);
  }
}

Vector3 momentum(const TissueModel& model, const TissueState& state) {
  Vector3 sum = Vector3::Zero();
  for (int i = 0; i < model.nodes(); ++i) sum += model.mass[i] * state.v.col(i);
  return sum;
}

TEST_CASE("the momentum of a free block changes by the applied force times h") {
  const TetrahedralMesh mesh = column();
  Material material = undamped_material();
  material.rayleigh_stiffness = 0.01;
  const TissueModel model = bench_tissue(mesh, material);
  constexpr double h = 1e-3;
  for (const TissueMatrix matrix : kMatrices) {
    BenchMotion motion(model, h, matrix, 1, 8);
    TissueState state = make_tissue_state(model);
    Random random(1);
    // Later, with nodes turned apart, the warped matrix keeps the balance only nearly; the exact one always does.
    const int ticks = matrix == TissueMatrix::refactorized ? 20 : 1;
    for (int i = 0; i < ticks; ++i) {
      const Vector3 before = momentum(model, state), n = random.direction();
      const double lambda = random.uniform(0.5, 1);
      motion.begin(state);
      for (int iteration = 0; iteration < 4; ++iteration) {
        motion.linearize(state);
        motion.clear_rows();
        REQUIRE(motion.add_row({{50, Eigen::Vector4d(0.1, 0.2, 0.3, 0.4)}, {}, 0}, n) == 0);
        motion.correct({&lambda, 1});
        if (matrix != TissueMatrix::refactorized) break;
      }
      motion.commit(state);
      const Vector3 change = momentum(model, state) - before;
      CHECK((change - lambda * h * n).norm() < std::max(1e-9, rounding(motion)) * lambda * h);
    }
  }
}

TEST_CASE("in every tick supports, weight and rows carry the inertia of the exact matrix") {
  const TetrahedralMesh mesh = column();
  const TissueModel model = bench_tissue(mesh, damped_material(0.4), at_bottom, {0, 0, -9.81});
  BenchMotion motion(model, 2e-3, TissueMatrix::refactorized, 1, 8);
  TissueState state = make_tissue_state(model);
  Random random(2);
  Vector3 row = Vector3::Zero();
  for (int i = 0; i < 30; ++i) {
    const double lambda = random.uniform(-0.1, 0.1);
    const Vector3 n = random.direction();
    const MaterialPoint point = random_point(mesh, random);
    motion.begin(state);
    for (int iteration = 0; iteration < 8; ++iteration) {
      motion.linearize(state);
      if (iteration == 0 && i > 0) {  // balance() speaks of the tick before
        const auto& b = motion.balance();
        CHECK((b.support + b.applied + row - b.inertia).norm() < 1e-8 * b.support.norm());
      }
      motion.clear_rows();
      REQUIRE(motion.add_row({point, {}, 0}, n) == 0);
      motion.correct({&lambda, 1});
    }
    motion.commit(state);
    row = lambda * n;
  }
}

// The rows' directions over the unknowns, in the world.
VectorX row_vector(const TissueModel& model, const TissuePoint& point, const Vector3& n) {
  VectorX row = VectorX::Zero(model.unknowns());
  const auto add = [&](const MaterialPoint& p, double share) {
    for (int k = 0; k < 4; ++k) {
      const auto& nodes = model.mesh->tetrahedra[static_cast<std::size_t>(p.tetrahedron)];
      const int free = model.free_index[static_cast<std::size_t>(nodes[static_cast<std::size_t>(k)])];
      if (free >= 0) row.segment<3>(3 * free) += share * p.weights[k] * n;
    }
  };
  add(point.a, 1 - point.u);
  if (point.u > 0) add(point.b, point.u);
  return row;
}

struct RowBench {
  TetrahedralMesh mesh = column();
  TissueModel model = bench_tissue(mesh, damped_material(0.4), at_bottom, {0, 0, -3});
  std::vector<TissuePoint> points;
  std::vector<Vector3> directions;

  RowBench() {
    Random random(3);
    for (int r = 0; r < 5; ++r) {
      points.push_back({random_point(mesh, random), random_point(mesh, random), r % 2 == 0 ? 0 : 0.3});
      directions.push_back(random.direction());
    }
  }
  MatrixX rows() const {
    MatrixX all(model.unknowns(), 5);
    for (std::size_t r = 0; r < 5; ++r) all.col(static_cast<int>(r)) = row_vector(model, points[r], directions[r]);
    return all;
  }
  void add_to(TissueMotion& motion) const {
    motion.clear_rows();
    for (std::size_t r = 0; r < 5; ++r) REQUIRE(motion.add_row(points[r], directions[r]) == static_cast<int>(r));
  }
  // Bent well away from rest, all of it or turned as a whole.
  TissueState bent() const {
    TissueState state = make_tissue_state(model);
    for (int i = 0; i < model.nodes(); ++i) state.x(0, i) += 3 * std::pow(state.x(2, i) + kHeight / 2, 2);
    return state;
  }
  TissueState turned(const Matrix3& turn) const {
    TissueState state = make_tissue_state(model);
    state.x = turn * mesh.nodes;
    return state;
  }
};

constexpr double kStep = 2e-3;
constexpr MatrixFactors kTick{
    .mass = 1 / (kStep * kStep), .mass_damping = 1 / kStep, .stiffness = 1, .stiffness_damping = 1 / kStep};

TEST_CASE("refactorized: compliance is that of the dense inverse of the tangent") {
  const RowBench bench;
  const TissueState state = bench.bent();
  BenchMotion motion(bench.model, kStep, TissueMatrix::refactorized, 5, 40);
  motion.begin(state);
  REQUIRE(motion.linearize(state));
  bench.add_to(motion);
  MatrixFactors undamped = kTick;
  undamped.stiffness_damping = 0;
  const MatrixX a = dense_matrix(bench.model, state.x, Tangent::exact, undamped) +
                    dense_matrix(bench.model, state.x, Tangent::turned, {.stiffness_damping = 1 / kStep});
  const MatrixX expected = bench.rows().transpose() * test::solve_dense(a, bench.rows());
  CHECK((Compliance(motion, 5).W - expected).norm() < 1e-11 * expected.norm());
}

TEST_CASE("turned: compliance is that of the dense inverse at rest, turned with the nodes") {
  const RowBench bench;
  const MatrixX inverse = test::inverse(dense_matrix(bench.model, bench.mesh.nodes, Tangent::rest, kTick));
  for (const double angle : {0.0, 0.8, 2.5}) {
    const Matrix3 turn = rotation_exp(angle * Vector3(0.6, 0, 0.8)).toRotationMatrix();
    const TissueState state = bench.turned(turn);
    BenchMotion motion(bench.model, kStep, TissueMatrix::turned, 5, 40);
    motion.begin(state);
    motion.linearize(state);
    bench.add_to(motion);
    MatrixX rows = bench.rows();
    for (int i = 0; i < rows.rows(); i += 3) rows.middleRows<3>(i) = turn.transpose() * rows.middleRows<3>(i);
    const MatrixX expected = rows.transpose() * inverse * rows;
    CHECK((Compliance(motion, 5).W - expected).norm() < rounding(motion) * expected.norm());
  }
}

TEST_CASE("rows at one point, at others, on a patch and on nothing: the dense inverse, in any order") {
  const RowBench bench;
  Random random(6);
  const MaterialPoint near = random_point(bench.mesh, random), far = random_point(bench.mesh, random);
  MaterialPoint patch[] = {random_point(bench.mesh, random), near, far};
  for (MaterialPoint& point : patch) point.weights /= 3;
  struct Kind {
    std::vector<MaterialPoint> points;
    int rows;  // one after the other
  };
  std::vector<Kind> kinds{{{near}, 6}, {{}, 2}, {{far}, 1}, {{near}, 3}, {{patch, patch + 3}, 3}, {{}, 1}, {{far}, 5}};
  const MatrixX inverse = test::inverse(dense_matrix(bench.model, bench.mesh.nodes, Tangent::rest, kTick));
  const TissueState state = make_tissue_state(bench.model);
  for (int order = 0; order < 5; ++order) {
    std::rotate(kinds.begin(), kinds.begin() + 2 * order % 7, kinds.end());
    BenchMotion motion(bench.model, kStep, TissueMatrix::turned, 21, 40);
    motion.begin(state);
    motion.linearize(state);
    motion.clear_rows();
    MatrixX rows = MatrixX::Zero(bench.model.unknowns(), 21);
    int count = 0;
    for (const Kind& kind : kinds) {
      for (int k = 0; k < kind.rows; ++k, ++count) {
        const Vector3 n = random.direction();
        const int row = kind.points.empty() ? motion.add_empty_row() : motion.add_row(kind.points, n);
        REQUIRE(row == count);
        for (const MaterialPoint& point : kind.points) rows.col(row) += row_vector(bench.model, {point, {}, 0}, n);
      }
    }
    const MatrixX expected = rows.transpose() * inverse * rows;
    CHECK((Compliance(motion, count).W - expected).norm() < rounding(motion) * expected.norm());
  }
}

TEST_CASE("free displacement and compliance say what the correction will do") {
  const RowBench bench;
  const VectorX lambda = Random(4).matrix(5, 1, 0.1);
  for (const TissueMatrix matrix : kMatrices) {
    TissueState state = bench.bent();
    state.v = Random(5).matrix(3, bench.model.nodes(), 0.1);
    for (int i = 0; i < bench.model.nodes(); ++i)
      if (bench.model.free_index[static_cast<std::size_t>(i)] < 0) state.v.col(i).setZero();
    BenchMotion motion(bench.model, kStep, matrix, 5, 40);
    motion.begin(state);
    motion.linearize(state);
    bench.add_to(motion);
    const Compliance compliance(motion, 5);
    const VectorX expected = compliance.W * lambda + Eigen::Map<const VectorX>(compliance.delta.data(), 5);
    const Matrix3X before = motion.x();
    motion.correct({lambda.data(), 5});
    for (std::size_t r = 0; r < 5; ++r) {
      const Vector3 moved = tissue_position(bench.mesh, motion.x(), bench.points[r]) -
                            tissue_position(bench.mesh, before, bench.points[r]);
      CHECK(std::abs(bench.directions[r].dot(moved) - expected[static_cast<int>(r)]) < 1e-11 * expected.norm());
    }
  }
}

TEST_CASE("shape gradients are those of the barycentric weights") {
  const RowBench bench;
  const Matrix3X x = bench.bent().x;
  constexpr double kProbe = 1e-6;  // m
  for (int t = 0; t < bench.mesh.tetrahedron_count(); t += 5) {
    const auto gradients = shape_gradients(bench.mesh, x, t);
    CHECK(gradients.rowwise().sum().norm() < 1e-12 * gradients.norm());
    const Vector3 middle = material_position(bench.mesh, x, {t, Eigen::Vector4d::Constant(0.25)});
    for (int axis = 0; axis < 3; ++axis) {
      const Vector3 probe = kProbe * Vector3::Unit(axis);
      const Eigen::Vector4d slope =
          (barycentric(bench.mesh, x, t, middle + probe) - barycentric(bench.mesh, x, t, middle - probe)) /
          (2 * kProbe);
      CHECK((gradients.row(axis).transpose() - slope).norm() < 1e-9 * gradients.norm());
    }
  }
}

TEST_CASE("a flat tetrahedron has no gradients, and does not turn") {
  const RowBench bench;
  const Matrix3X flat = Vector3(1, 1, 0).asDiagonal() * bench.mesh.nodes;
  CHECK(shape_gradients(bench.mesh, flat, 3).isZero(0));
  CHECK(material_rotation(bench.mesh, bench.mesh.nodes, flat, 3).isZero(0));
}

TEST_CASE("the rotation of the material is that of a small turn; strain and shift add nothing") {
  const RowBench bench;
  const Matrix3X from = bench.bent().x;
  Random random(6);
  for (int repeat = 0; repeat < 20; ++repeat) {
    const int t = random.index(bench.mesh.tetrahedron_count());
    const Vector3 turn = random.vector(1e-7);
    Matrix3 strain = random.matrix(3, 3, 1e-7);
    strain += strain.transpose().eval();
    const Matrix3X x = ((rotation_exp(turn).toRotationMatrix() + strain) * from).colwise() + random.vector(1e-3);
    CHECK((material_rotation(bench.mesh, from, x, t) - turn).norm() < 1e-5 * turn.norm());
  }
}

TEST_CASE("the rotation of the material is half the curl of its displacement") {
  const RowBench bench;
  const Matrix3X from = bench.bent().x;
  Matrix3X x = from + MatrixX(Random(7).matrix(3, bench.model.nodes(), 1e-5));
  constexpr double kProbe = 1e-6;  // m
  for (int t = 0; t < bench.mesh.tetrahedron_count(); t += 7) {
    // Displacement at a place of x, from the weights that the place has in x.
    const auto displacement = [&](const Vector3& p) {
      const MaterialPoint point{t, barycentric(bench.mesh, x, t, p)};
      return Vector3(p - material_position(bench.mesh, from, point));
    };
    const Vector3 middle = material_position(bench.mesh, x, {t, Eigen::Vector4d::Constant(0.25)});
    Vector3 curl = Vector3::Zero();
    for (int axis = 0; axis < 3; ++axis) {
      const Vector3 probe = kProbe * Vector3::Unit(axis);
      curl += Vector3::Unit(axis).cross(displacement(middle + probe) - displacement(middle - probe)) / (2 * kProbe);
    }
    CHECK((material_rotation(bench.mesh, from, x, t) - curl / 2).norm() < 1e-6 * curl.norm());
  }
}

// What one newton on the only row of a tick changes, against the same tick without force.
Matrix3X moved_by(TissueMotion& motion, const TissueState& state, const std::function<int()>& add_row) {
  Matrix3X end[2];
  for (int with = 0; with < 2; ++with) {
    motion.begin(state);
    motion.linearize(state);
    motion.clear_rows();
    REQUIRE(add_row() == 0);
    const double lambda = with;
    motion.correct({&lambda, 1});
    end[with] = motion.x();
  }
  return end[1] - end[0];
}

TEST_CASE("a couple does the work of the rotation that its row reports") {
  // Virtual work: what the row calls its displacement, W lambda, is the torque times the rotation of the material.
  const RowBench bench;
  for (const TissueMatrix matrix : kMatrices) {
    const TissueState state = bench.bent();
    Random random(8);
    for (int repeat = 0; repeat < 10; ++repeat) {
      const int t = random.index(bench.mesh.tetrahedron_count());
      const Vector3 torque = 1e-4 * random.direction();  // m: N m for a newton
      BenchMotion motion(bench.model, kStep, matrix, 1, 12);
      const Matrix3X moved = moved_by(motion, state, [&] { return motion.add_couple(t, torque); });
      const double reported = Compliance(motion, 1).W(0, 0);
      // The gradients are those of the configuration in which the couple was added, state.x.
      const auto gradients = shape_gradients(bench.mesh, state.x, t);
      Vector3 rotation = Vector3::Zero();
      for (int k = 0; k < 4; ++k) {
        const int node = bench.mesh.tetrahedra[static_cast<std::size_t>(t)][static_cast<std::size_t>(k)];
        rotation += gradients.col(k).cross(moved.col(node)) / 2;
      }
      CHECK(reported > 0);
      CHECK(torque.dot(rotation) == doctest::Approx(reported).epsilon(1e-9).scale(0));
    }
  }
}

TEST_CASE("a couple and a force do equal work on each other") {
  const RowBench bench;
  const TissueState state = bench.bent();
  const Vector3 torque(2e-4, -1e-4, 3e-4);
  for (const TissueMatrix matrix : kMatrices) {
    BenchMotion motion(bench.model, kStep, matrix, 2, 40);
    motion.begin(state);
    motion.linearize(state);
    motion.clear_rows();
    REQUIRE(motion.add_couple(20, torque) == 0);
    REQUIRE(motion.add_row(bench.points[0], bench.directions[0]) == 1);
    const double coupled = Compliance(motion, 2).W(1, 0);
    const Matrix3X moved = moved_by(motion, state, [&] { return motion.add_couple(20, torque); });
    const double at_point = bench.directions[0].dot(tissue_position(bench.mesh, state.x + moved, bench.points[0]) -
                                                    tissue_position(bench.mesh, state.x, bench.points[0]));
    CHECK(at_point == doctest::Approx(coupled).epsilon(1e-9).scale(0));
  }
}

TEST_CASE("a couple is balanced: it has no resultant, and its moment is the torque") {
  // On free tissue the change of momentum and of angular momentum in a tick is the resultant's, times h.
  const TetrahedralMesh mesh = column();
  const TissueModel model = bench_tissue(mesh, undamped_material());
  const TissueState state = make_tissue_state(model);
  const Vector3 torque(2e-4, -1e-4, 3e-4);
  for (const TissueMatrix matrix : kMatrices) {
    BenchMotion motion(model, kStep, matrix, 1, 12);
    const Matrix3X moved = moved_by(motion, state, [&] { return motion.add_couple(20, torque); });
    Vector3 force = Vector3::Zero(), moment = Vector3::Zero();
    for (int i = 0; i < model.nodes(); ++i) {
      const Vector3 share = model.mass[i] * moved.col(i) / (kStep * kStep);
      force += share;
      moment += Vector3(mesh.nodes.col(i)).cross(share);
    }
    CHECK(force.norm() < std::max(1e-9, rounding(motion)) * torque.norm() / kHeight);
    CHECK((moment - torque).norm() < 1e-6 * torque.norm());
  }
}

TEST_CASE("a row that does not act on the tissue has no compliance and moves nothing") {
  const RowBench bench;
  BenchMotion motion(bench.model, kStep, TissueMatrix::turned, 2, 12);
  const Matrix3X moved = moved_by(motion, bench.bent(), [&] { return motion.add_empty_row(); });
  CHECK(moved.cwiseAbs().maxCoeff() < 1e-15);  // rounding of two runs
  const Compliance compliance(motion, 1);
  CHECK(compliance.W(0, 0) == 0);
  CHECK(compliance.delta[0] == 0);
}

TEST_CASE("a corridor that is too small says so and harms no other row") {
  const RowBench bench;
  BenchMotion motion(bench.model, kStep, TissueMatrix::turned, 5, 4);
  const TissueState state = make_tissue_state(bench.model);
  motion.begin(state);
  motion.linearize(state);
  motion.clear_rows();
  REQUIRE(motion.add_row({{50, Eigen::Vector4d::Constant(0.25)}, {}, 0}, Vector3::UnitX()) == 0);
  const double alone = Compliance(motion, 1).W(0, 0);
  CHECK(motion.add_row(bench.points[1], Vector3::UnitX()) == -1);
  CHECK(Compliance(motion, 1).W(0, 0) == alone);
}

TEST_CASE("constant: a tick is that of the linear system, however far the tissue is from rest") {
  const RowBench bench;
  TissueState state = bench.bent();
  state.v = Random(9).matrix(3, bench.model.nodes(), 0.1);
  BenchMotion motion(bench.model, kStep, TissueMatrix::constant, 1, 8);
  motion.begin(state);
  motion.linearize(state);
  motion.clear_rows();
  motion.correct({});

  // Forces of the rest stiffness over all nodes, from a model in which none is fixed.
  const TissueModel unsupported = bench_tissue(bench.mesh, damped_material(0.4));
  const MatrixX k = dense_matrix(unsupported, bench.mesh.nodes, Tangent::rest, {.stiffness = 1});
  const Matrix3X displacement = state.x - bench.mesh.nodes;
  const VectorX elastic = k * Eigen::Map<const VectorX>(displacement.data(), displacement.size());
  VectorX rhs(bench.model.unknowns());
  for (int f = 0; f < rhs.size() / 3; ++f) {
    const int i = bench.model.free_nodes[static_cast<std::size_t>(f)];
    rhs.segment<3>(3 * f) =
        bench.model.applied.col(i) + bench.model.mass[i] * state.v.col(i) / kStep - elastic.segment<3>(3 * i);
  }
  const VectorX expected = test::solve_dense(dense_matrix(bench.model, bench.mesh.nodes, Tangent::rest, kTick), rhs);
  for (int f = 0; f < rhs.size() / 3; ++f) {
    const int i = bench.model.free_nodes[static_cast<std::size_t>(f)];
    CHECK((motion.x().col(i) - state.x.col(i) - expected.segment<3>(3 * f)).norm() < 1e-6 * expected.norm());
  }
}

TEST_CASE("constant: supports carry the weight and the forces of the linear tissue") {
  const TetrahedralMesh mesh = column();
  const TissueModel model = bench_tissue(mesh, damped_material(0.4), at_bottom, {0, 0, -3});
  BenchMotion motion(model, 5e-3, TissueMatrix::constant, 1, 1);
  TissueState state = make_tissue_state(model);
  for (int i = 0; i < 2000; ++i) tick(motion, state);
  const TissueBalance& b = motion.balance();
  CHECK(b.applied.z() < 0);
  CHECK((b.support + b.applied).norm() < 1e-8 * b.applied.norm());
}

TEST_CASE("repeated, the turned matrix comes to the step of the refactorized one") {
  const TetrahedralMesh mesh = column();
  const TissueModel model = bench_tissue(mesh, damped_material(0.4), at_bottom, {0, 0, -3});
  TissueState start = make_tissue_state(model);
  for (int i = 0; i < model.nodes(); ++i) start.x(0, i) += 0.6 * std::pow(start.x(2, i) + kHeight / 2, 2);
  for (const int i : model.free_nodes) start.v.col(i) = Random(static_cast<unsigned>(i)).vector(0.05);
  Matrix3X end[2];
  for (int m = 0; m < 2; ++m) {
    BenchMotion motion(model, kStep, m == 0 ? TissueMatrix::turned : TissueMatrix::refactorized, 1, 8);
    motion.begin(start);
    for (int iteration = 0; iteration < 30; ++iteration) {
      motion.linearize(start);
      motion.clear_rows();
      motion.correct({});
    }
    end[m] = motion.x();
  }
  CHECK((end[0] - end[1]).cwiseAbs().maxCoeff() < 1e-10 * (end[1] - start.x).cwiseAbs().maxCoeff());
}

TEST_CASE("materials that differ by many orders of magnitude: double precision where it takes that") {
  const TetrahedralMesh mesh = column();
  Material soft = damped_material(0.4), stiff = soft;
  for (const double ratio : {1.0, 1e3, 1e5, 1e10}) {
    stiff.young_modulus = ratio * soft.young_modulus;
    const Material materials[] = {soft, stiff};
    std::vector<int> region(mesh.tetrahedra.size(), 0);
    for (std::size_t t = 0; t < region.size(); ++t) {
      const Vector3 middle = material_position(mesh, mesh.nodes, {static_cast<int>(t), Eigen::Vector4d::Constant(0.25)});
      if (middle.z() > 0) region[t] = 1;  // held by nothing but the soft half
    }
    std::vector<bool> fixed(static_cast<std::size_t>(mesh.node_count()));
    for (int i = 0; i < mesh.node_count(); ++i) fixed[static_cast<std::size_t>(i)] = at_bottom(mesh.nodes.col(i));
    const TissueModel model = make_tissue_model(mesh, region, materials, fixed, Vector3::Zero());
    BenchMotion motion(model, 1e-2, TissueMatrix::turned, 1, 8);
    if (ratio == 1) CHECK(motion.precision() == Precision::single_precision);
    if (ratio == 1e10) CHECK(motion.precision() == Precision::double_precision);

    // In the stiff half, where rounding of its stiffness could drown what holds it.
    const TissuePoint point{{mesh.tetrahedron_count() - 1, Eigen::Vector4d(0.1, 0.2, 0.3, 0.4)}, {}, 0};
    REQUIRE(region[static_cast<std::size_t>(point.a.tetrahedron)] == 1);
    const TissueState state = make_tissue_state(model);
    motion.begin(state);
    motion.linearize(state);
    motion.clear_rows();
    REQUIRE(motion.add_row(point, Vector3::UnitX()) == 0);
    const MatrixX a = dense_matrix(model, mesh.nodes, Tangent::rest,
                                   {.mass = 1e4, .mass_damping = 1e2, .stiffness = 1, .stiffness_damping = 1e2});
    const VectorX row = row_vector(model, point, Vector3::UnitX());
    const double expected = row.dot(VectorX(test::solve_dense(a, row)));
    const double error = std::abs(Compliance(motion, 1).W(0, 0) / expected - 1);
    MESSAGE("stiffness ratio " << ratio << ": compliance off by " << error);
    CHECK(error < 2 * TissueSystem::kSinglePrecisionError);
  }
}

// A point that is pushed for 60 ticks of `iterations` each, and then left alone for 60; of each the displacement.
std::vector<Vector3> pushed(BenchMotion& motion, const TissueModel& model, int iterations) {
  const MaterialPoint point{model.mesh->tetrahedron_count() - 1, Eigen::Vector4d(0.1, 0.2, 0.3, 0.4)};
  const Vector3 rest = material_position(*model.mesh, model.mesh->nodes, point);
  TissueState state = make_tissue_state(model);
  std::vector<Vector3> displacements;
  for (int i = 0; i < 120; ++i) {
    motion.begin(state);
    for (int iteration = 0; iteration < iterations; ++iteration) {
      motion.linearize(state);
      motion.clear_rows();
      REQUIRE(motion.add_row(TissuePoint{point, {}, 0}, Vector3(1, 0, -1).normalized()) == 0);
      const double force[] = {i < 60 ? 0.01 : 0.0};  // N
      motion.correct(force);
    }
    motion.commit(state);
    displacements.push_back(material_position(*model.mesh, state.x, point) - rest);
  }
  return displacements;
}

TEST_CASE("a large factor in few bits moves the tissue as converged ticks do" * doctest::test_suite("gate")) {
  const TetrahedralMesh mesh = make_box_mesh({0.1, 0.1, 0.1}, {14, 14, 14});
  const TissueModel model = bench_tissue(mesh, damped_material(0.45), [](const Vector3& p) { return p.z() < -0.0499; });
  BenchMotion motion(model, 1e-3, TissueMatrix::turned, 1, 8), converged(model, 1e-3, TissueMatrix::turned, 1, 8);
  REQUIRE(motion.precision() == Precision::half_precision);
  const std::vector<Vector3> once = pushed(motion, model, 1), often = pushed(converged, model, 6);
  double largest = 0, apart = 0;
  for (std::size_t i = 0; i < once.size(); ++i) {
    largest = std::max(largest, often[i].norm());
    apart = std::max(apart, (once[i] - often[i]).norm());
  }
  MESSAGE("largest " << largest << " m, apart " << apart << " m");
  CHECK(largest > 1e-4);
  CHECK(apart < 2e-3 * largest);
  CHECK((once.back() - often.back()).norm() < 5e-3 * largest);
}

TEST_CASE("nodes made ready over ticks are those that rows on the tetrahedron need") {
  const RowBench bench;
  BenchMotion motion(bench.model, kStep, TissueMatrix::turned, 1, 8);
  const TissueState state = make_tissue_state(bench.model);
  int ticks = 0;
  do motion.begin(state), ++ticks;
  while (motion.prepare(bench.points[0].a.tetrahedron) && ticks < 1000);
  CHECK(ticks > 4);
  CHECK(ticks < 100);
  motion.begin(state);
  CHECK_FALSE(motion.prepare(bench.points[0].a.tetrahedron));
  int free = 0;
  for (const int node : bench.mesh.tetrahedra[static_cast<std::size_t>(bench.points[0].a.tetrahedron)])
    free += bench.model.free_index[static_cast<std::size_t>(node)] >= 0;
  CHECK(motion.corridor_used() == free);
}

TEST_CASE("tissue without a free node is no tissue") {
  const TetrahedralMesh mesh = column();
  const TissueModel model = bench_tissue(mesh, damped_material(0.4), [](const Vector3&) { return true; }, {0, 0, -3});
  for (const TissueMatrix matrix : kMatrices) {
    BenchMotion motion(model, kStep, matrix, 1, 8);
    TissueState state = make_tissue_state(model);
    motion.begin(state);
    CHECK(motion.linearize(state));
    motion.clear_rows();
    CHECK(motion.add_row({{50, Eigen::Vector4d::Constant(0.25)}, {}, 0}, Vector3::UnitX()) == 0);
    CHECK(Compliance(motion, 1).W(0, 0) == 0);
    const double lambda = 1;
    CHECK(motion.correct({&lambda, 1}) == 0);
    motion.commit(state);
    CHECK((state.x - mesh.nodes).isZero(0));
  }
}

TEST_CASE("a run repeats itself bit for bit, whatever the corridor holds from before") {
  const RowBench bench;
  for (const TissueMatrix matrix : kMatrices) {
    BenchMotion motion(bench.model, kStep, matrix, 5, 10);
    Matrix3X end[2];
    for (Matrix3X& x : end) {
      TissueState state = bench.bent();
      for (int i = 0; i < 10; ++i) {
        motion.begin(state);
        motion.linearize(state);
        motion.clear_rows();
        motion.add_row(bench.points[static_cast<std::size_t>(2 * (i % 3))], Vector3::UnitX());
        const double lambda = 0.05;
        motion.correct({&lambda, 1});
        motion.commit(state);
      }
      x = state.x;
    }
    CHECK((end[0].array() == end[1].array()).all());
  }
}

}  // namespace
}  // namespace acus
