// SPDX-License-Identifier: GPL-3.0-or-later
// The deferred field against the tissue that moves at every tick: rest, an impulse, nodes that come to be held and are let
// go, the same bits whatever has been done before; and its low modes against the dense problem.
#include <doctest/doctest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <numbers>

#include "server/engine/math/random.h"
#include "server/engine/models/field/field_task.h"
#include "tests/models/bench_tissue.h"
#include "tests/models/motions.h"
#include "tests/support/dense.h"

namespace acus {
namespace {

constexpr double kHeight = 0.1, kStep = 1e-3;

bool at_bottom(const Vector3& p) { return p.z() < -kHeight / 2 + 1e-9; }

Material material_of(double rayleigh_stiffness) {
  Material material = undamped_material();
  material.rayleigh_mass = 0.1;
  material.rayleigh_stiffness = rayleigh_stiffness;
  return material;
}

// A block on its bottom face, with and without a deferred field.
struct FieldBench {
  TetrahedralMesh mesh = make_box_mesh({0.08, 0.08, kHeight}, {4, 4, 5});
  TissueModel model;

  explicit FieldBench(const Vector3& gravity = Vector3::Zero(), double rayleigh_stiffness = 0.01)
      : model(bench_tissue(mesh, material_of(rayleigh_stiffness), at_bottom, gravity)) {}
};

class FieldMotion : private BenchSystem, public TissueMotion {
 public:
  FieldMotion(const TissueModel& model, int window, const TissueState* equilibrium = nullptr, double h = kStep)
      : BenchSystem{{model, h, TissueMatrix::turned, window, false, equilibrium}}, TissueMotion(system, 1, 40) {}

  TissueState state(const TissueState* equilibrium = nullptr) const {
    TissueState state = make_tissue_state(system.model);
    if (equilibrium) state.x = equilibrium->x, state.rotations = equilibrium->rotations;
    if (system.field) state.field = make_field_state(system, 40, equilibrium);
    return state;
  }
  const TissueSystem& tissue() const { return system; }
  void increase_by(double times) { system.field->increase = times; }
};

// A tick with a force (N) on a point.
void tick(TissueMotion& motion, TissueState& state, const MaterialPoint& point, const Vector3& force) {
  motion.begin(state);
  motion.linearize(state);
  motion.clear_rows();
  const double lambda = force.norm();
  if (lambda > 0) REQUIRE(motion.add_row({point, {}, 0}, force / lambda) == 0);
  motion.correct({&lambda, lambda > 0 ? 1u : 0u});
  motion.commit(state);
}

const MaterialPoint kNone{};

MaterialPoint middle_of(int tetrahedron) { return {tetrahedron, Eigen::Vector4d::Constant(0.25)}; }

double largest_difference(const Matrix3X& a, const Matrix3X& b) { return (a - b).cwiseAbs().maxCoeff(); }

// Under the weight of the model, by long ticks.
TissueState at_rest(const TissueModel& model) {
  FieldMotion motion(model, 0, nullptr, 1);
  TissueState state = motion.state();
  for (int i = 0; i < 1000; ++i) {
    const Matrix3X before = state.x;
    tick(motion, state, kNone, Vector3::Zero());
    if (largest_difference(state.x, before) < 1e-12) return state;
  }
  FAIL("it comes to no rest");
  return state;
}

}  // namespace

TEST_CASE("low modes are the lowest of the dense eigenproblem") {
  const FieldBench bench;
  const FieldMotion motion(bench.model, 8);
  const DeferredField& field = *motion.tissue().field;
  const MatrixX stiffness = dense_matrix(bench.model, bench.mesh.nodes, Tangent::rest, {.stiffness = 1});
  const MatrixX mass = dense_matrix(bench.model, bench.mesh.nodes, Tangent::rest, {.mass = 1});
  const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixX> exact(stiffness, mass);
  REQUIRE(field.modes.count() == DeferredField::kModes);
  for (int k = 0; k < 12; ++k) CHECK(field.modes.omega2[k] == doctest::Approx(exact.eigenvalues()[k]).epsilon(0.01));
  const MatrixX shapes = field.modes.shapes.cast<double>();
  VectorX masses(shapes.rows());
  for (std::size_t f = 0; f < bench.model.free_nodes.size(); ++f)
    masses.segment<3>(motion.tissue().position[f]).setConstant(bench.model.mass[bench.model.free_nodes[f]]);
  const MatrixX gram = shapes.transpose() * masses.asDiagonal() * shapes;
  CHECK((gram - MatrixX::Identity(gram.rows(), gram.cols())).cwiseAbs().maxCoeff() < 1e-5);
}

TEST_CASE("a column under its weight comes to the same rest with a deferred field as without, and stays" *
          doctest::test_suite("gate")) {
  const FieldBench bench({0.5, 0, -3});
  FieldMotion every_tick(bench.model, 0);
  TissueState expected = every_tick.state();
  for (int i = 0; i < 6000; ++i) tick(every_tick, expected, kNone, Vector3::Zero());
  CHECK(largest_difference(expected.x, bench.mesh.nodes) > 1e-3);
  for (const int window : {1, 5, 16}) {
    CAPTURE(window);
    FieldMotion motion(bench.model, window);
    TissueState state = motion.state();
    for (int i = 0; i < 6000; ++i) tick(motion, state, kNone, Vector3::Zero());
    CHECK(largest_difference(state.x, expected.x) < 1e-8);
    const Matrix3X at_rest = state.x;
    for (int i = 0; i < 4000; ++i) tick(motion, state, kNone, Vector3::Zero());
    CHECK(largest_difference(state.x, at_rest) < 1e-8);
    CHECK(state.field->window->left.norm() < 1e-9);
  }
}

// A push of 60 ms, as short as those of hands: hits of few ticks meet inertia that 24 modes have not.
double push(int tick) { return tick < 60 ? 0.1 * std::pow(std::sin(std::numbers::pi * tick / 60), 2) : 0; }

TEST_CASE("a point that is pushed moves as it does without a deferred field, whatever window and damping") {
  const MaterialPoint point = middle_of(200);
  for (const double beta : {0.005, 0.01, 0.05}) {
    const FieldBench bench(Vector3::Zero(), beta);
    for (const int window : {1, 4, 16}) {
      CAPTURE(beta);
      CAPTURE(window);
      FieldMotion every_tick(bench.model, 0), motion(bench.model, window);
      TissueState expected = every_tick.state(), state = motion.state();
      double largest = 0, off = 0, off_later = 0;
      for (int i = 0; i < 200; ++i) {
        const Vector3 force = push(i) * Vector3(0.5, 0.2, -1);
        tick(every_tick, expected, point, force);
        tick(motion, state, point, force);
        const Vector3 moved = material_position(bench.mesh, expected.x, point) - material_position(bench.mesh, bench.mesh.nodes, point);
        largest = std::max(largest, moved.norm());
        const double here = (material_position(bench.mesh, state.x, point) - material_position(bench.mesh, expected.x, point)).norm();
        (i < 60 ? off : off_later) = std::max(i < 60 ? off : off_later, here);
      }
      CHECK(off < 0.07 * std::sqrt(0.005 / beta) * largest);
      CHECK(off_later < 0.03 * (2 + window) * largest);  // not held any more, and shown where it is expected
    }
  }
}

TEST_CASE("free displacement and compliance say what a held node will do") {
  const FieldBench bench({0, 0, -3});
  FieldMotion motion(bench.model, 6);
  TissueState state = motion.state();
  Random random(1);
  for (int i = 0; i < 40; ++i) {
    const MaterialPoint point = middle_of(100 + i);
    const Vector3 n = random.direction(), before = material_position(bench.mesh, state.x, point);
    const double lambda = 0.1;
    motion.begin(state);
    motion.linearize(state);
    motion.clear_rows();
    REQUIRE(motion.add_row({point, {}, 0}, n) == 0);
    MatrixX W = MatrixX::Zero(1, 1);
    double delta = 0;
    motion.set_compliance(W, {&delta, 1});
    const Vector3 start = material_position(bench.mesh, motion.x(), point);  // its nodes are held by now
    CHECK((start - before).norm() < 1e-4);
    motion.correct({&lambda, 1});
    const Vector3 moved = material_position(bench.mesh, motion.x(), point) - start;
    CHECK(n.dot(moved) == doctest::Approx(delta + W(0, 0) * lambda).epsilon(1e-9));
    motion.commit(state);
  }
}

TEST_CASE("no result depends on what a window's work has been done before, or on which slots nodes have") {
  const FieldBench bench({0, 0, -3});
  FieldMotion motion(bench.model, 6);
  TissueState state = motion.state();
  Random random(2);
  for (int i = 0; i < 40; ++i) {
    FieldMotion fresh(bench.model, 6);
    TissueState other = state;
    const MaterialPoint point = middle_of(100 + random.index(8));
    const Vector3 force = i % 9 < 5 ? random.vector(0.05) : Vector3::Zero();
    tick(fresh, other, point, force);
    tick(motion, state, point, force);
    REQUIRE(largest_difference(state.x, other.x) == 0);
    REQUIRE(largest_difference(state.v, other.v) == 0);
    REQUIRE(state.field->d == other.field->d);
  }
}

TEST_CASE("nodes that no force acts on are let go, and what they carry goes on") {
  const FieldBench bench;
  FieldMotion every_tick(bench.model, 0), motion(bench.model, 4);
  TissueState expected = every_tick.state(), state = motion.state();
  const MaterialPoint point = middle_of(150);
  const auto run = [&](int ticks, const Vector3& force) {
    for (int i = 0; i < ticks; ++i) {
      tick(every_tick, expected, point, force);
      tick(motion, state, point, force);
    }
  };
  run(200, {0, 0.02, -0.05});
  CHECK(state.field->held.size() == 4);
  const double pressed = largest_difference(expected.x, bench.mesh.nodes);
  run(12, Vector3::Zero());
  CHECK(state.field->held.empty());
  CHECK(largest_difference(state.x, expected.x) < 0.1 * pressed);
  run(60, Vector3::Zero());
  CHECK(largest_difference(state.x, expected.x) < 0.05 * pressed);
  run(4000, Vector3::Zero());
  CHECK(largest_difference(state.x, expected.x) < 1e-4 * pressed);
}

TEST_CASE("tissue that is crushed by a weight it cannot bear stays finite, and is held back rather than thrown about") {
  const FieldBench bench({0, 0, -60});  // 6 kPa on the bottom, of a Young's modulus of 10 kPa
  FieldMotion motion(bench.model, 8);
  TissueState state = motion.state();
  double share = 1;
  for (int i = 0; i < 3000; ++i) {
    tick(motion, state, kNone, Vector3::Zero());
    share = std::min(share, state.field->window->share);
    REQUIRE(largest_difference(state.x, bench.mesh.nodes) < 3 * kHeight);
    REQUIRE(state.x.allFinite());
  }
  CHECK(share < 0.5);
}

// Whether a push dies away in tissue that has become (1 + r) times as stiff as the field's matrix.
bool dies_away(double r, int window, double increase = 1) {
  FieldBench bench;
  FieldMotion motion(bench.model, window);
  motion.increase_by(increase);
  for (ElementBatch& batch : bench.model.batches) {
    for (double& mu : batch.shape.law.mu.at) mu *= 1 + r;
    for (double& lambda : batch.shape.law.lambda.at) lambda *= 1 + r;
  }
  TissueState state = motion.state();
  auto largest_until = [&, i = 0](int end) mutable {
    double largest = 0;
    for (; i < end; ++i) {
      tick(motion, state, middle_of(200), push(i) * Vector3(1e-3, 1e-3, -1e-3));
      largest = std::max(largest, largest_difference(state.x, bench.mesh.nodes));
    }
    return largest;
  };
  const double pushed = largest_until(500);
  largest_until(8000);
  return largest_until(8500) < 0.01 * pushed;
}

TEST_CASE("motions die away in tissue that is not much stiffer or softer than the field's matrix" *
          doctest::test_suite("gate")) {
  for (const auto& [window, bearable] : {std::pair{8, 0.9}, {16, 0.45}, {32, 0.23}}) {
    CAPTURE(window);
    CHECK(dies_away(0.6 * bearable, window));
    CHECK_FALSE(dies_away(1.5 * bearable, window));
  }
  CHECK(dies_away(-0.45, 32));
  CHECK_FALSE(dies_away(-0.75, 32));
  CHECK(dies_away(-0.75, 32, 0));
  CHECK(dies_away(-0.9, 32, 0));
}

TEST_CASE("about an equilibrium the field's matrix is that of small motions there, in the frames of its nodes") {
  const FieldBench bench({8, 3, 8});
  const TissueState rest = at_rest(bench.model);
  CHECK(largest_difference(rest.x, bench.mesh.nodes) > 0.02);
  const TissueSystem system(bench.model, kStep, TissueMatrix::turned, 8, false, &rest);
  REQUIRE(system.field->about_equilibrium);

  const Matrix4X frames = node_frames(system, rest.rotations);
  const Matrix3X moved = Random(5).matrix(3, bench.model.nodes(), 1e-8);  // m, in the frames
  const auto forces_at = [&](double share) {
    Matrix3X x = rest.x, forces(3, bench.model.nodes());
    for (const int node : bench.model.free_nodes) x.col(node) += share * (rotation_of(frames, node) * moved.col(node));
    ElementRotations rotations = rest.rotations;
    elastic_forces(bench.model, x, rotations, forces);
    return forces;
  };
  const Matrix3X change = (forces_at(1) - forces_at(-1)) / 2;
  VectorX solution(bench.model.unknowns());
  for (std::size_t f = 0; f < system.position.size(); ++f) {
    const int node = bench.model.free_nodes[f];
    solution.segment<3>(system.position[f]) =
        system.field->c2 * (rotation_of(frames, node).conjugate() * Vector3(change.col(node)));
  }
  MatrixX panel_rows = system.factor.make_panel_rows();
  system.factor.forward(solution, panel_rows);
  system.factor.backward(solution, panel_rows);
  double off = 0;
  for (std::size_t f = 0; f < system.position.size(); ++f)
    off = std::max(off, (solution.segment<3>(system.position[f]) - moved.col(bench.model.free_nodes[f])).norm());
  CHECK(off < 1e-3 * 1e-8);
}

TEST_CASE("tissue that is stretched by a fifth swings out after a push, whatever its window" *
          doctest::test_suite("gate")) {
  const FieldBench bench({0, 0, 40});
  const TissueState rest = at_rest(bench.model);
  for (const int window : {8, 16, 32}) {
    CAPTURE(window);
    FieldMotion motion(bench.model, window, &rest);
    TissueState state = motion.state(&rest);
    const auto run = [&](int from, int to) {
      double largest = 0;
      for (int i = from; i < to; ++i) {
        tick(motion, state, middle_of(200), push(i) * Vector3(0.5, 0.2, -1));
        largest = std::max(largest, largest_difference(state.x, rest.x));
      }
      return largest;
    };
    const double pushed = run(0, 400);
    CHECK(pushed > 1e-4);
    CHECK(run(400, 6000) < pushed);
    CHECK(run(6000, 7000) < 1e-3 * pushed);
    CHECK(state.field->window->share == 1);
  }
}

TEST_CASE("a column that is about to buckle keeps the matrix of its rest shape") {
  const FieldBench bench({0, 0, -31});
  const TissueState rest = at_rest(bench.model);
  const TissueSystem system(bench.model, kStep, TissueMatrix::turned, 8, false, &rest);
  CHECK_FALSE(system.field->about_equilibrium);
  FieldMotion motion(bench.model, 32, &rest);
  TissueState state = motion.state(&rest);
  for (int i = 0; i < 4000; ++i) tick(motion, state, middle_of(200), push(i) * Vector3(0.01, 0, 0));
  CHECK(largest_difference(state.x, rest.x) < 1e-8);
  CHECK(system.field->modes.omega2[0] ==
        TissueSystem(bench.model, kStep, TissueMatrix::turned, 8).field->modes.omega2[0]);
}

TEST_CASE("tissue that no support holds has no deferred field") {
  const TetrahedralMesh mesh = make_box_mesh({0.05, 0.05, 0.05}, {2, 2, 2});
  const TissueModel model = bench_tissue(mesh, material_of(0.01));
  CHECK_THROWS_AS(TissueSystem(model, kStep, TissueMatrix::turned, 8), std::runtime_error);
}

}  // namespace acus
