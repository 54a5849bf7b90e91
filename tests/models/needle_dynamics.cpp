// SPDX-License-Identifier: GPL-3.0-or-later
// Needles in motion: free vibration against beam theory, spin, rest, and the balance of a tick.
#include <doctest/doctest.h>

#include "server/engine/math/random.h"
#include "server/engine/math/rotation.h"
#include "tests/models/bench_needle.h"

namespace acus {
namespace {

constexpr double kPi = std::numbers::pi;

void tick(NeedleMotion& motion, NeedleState& state, const Pose& base) {
  motion.begin(state, base);
  motion.linearize(state);
  motion.clear_rows();
  motion.correct({});
  motion.commit(state);
}

TEST_CASE("a plucked needle swings at the first frequency of a clamped beam and decays as backward Euler does") {
  const NeedleModel model = make_needle_model(bench_body(), Vector3::Zero());
  const double area = kPi / 4 * model.diameter * model.diameter;
  const double expected =
      1.8751041 * 1.8751041 * std::sqrt(model.stiffness.bending / (7800 * area * std::pow(model.length, 4)));

  constexpr double h = 1e-4;
  NeedleState state = find_equilibrium(model, {}, tip_load(model, {0, 1e-3, 0}, Vector3::Zero())).state;
  NeedleMotion motion(model, h, 1);
  std::vector<double> crossings, peaks;  // ticks, m
  double before = state.x(1, model.beams), peak = 0;
  for (int i = 1; crossings.size() < 11 && i < 10000; ++i) {
    tick(motion, state, {});
    const double y = state.x(1, model.beams);
    if ((y > 0) != (before > 0)) {
      crossings.push_back(i - y / (y - before));
      peaks.push_back(peak);
      peak = 0;
    }
    peak = std::max(peak, std::abs(y));
    before = y;
  }
  REQUIRE(crossings.size() == 11);
  // Backward Euler multiplies a mode of frequency w by 1/(1 + i w h) per tick: its phase advances by atan(w h), its
  // size shrinks by cos(atan(w h)). The first two half-periods are left to the higher modes to die away.
  const double phase = kPi * 8 / (crossings[10] - crossings[2]);
  CHECK(std::tan(phase) / h == doctest::Approx(expected).epsilon(5e-4));
  const double shrink = std::pow(peaks[10] / peaks[4], 1 / (crossings[10] - crossings[4]));
  CHECK(shrink == doctest::Approx(std::cos(phase)).epsilon(1e-5));
}

TEST_CASE("damped ticks come to rest in the equilibrium of the statics") {
  NeedleBody body = bench_body();
  body.beams = 20;
  body.material.rayleigh_mass = 300;
  body.material.rayleigh_stiffness = 1e-4;
  const NeedleModel model = make_needle_model(body, Vector3::Zero());
  const Vector3 force(0, 0.3, -0.8);
  const NeedleLoad load = tip_load(model, force, Vector3::Zero());
  const NeedleState expected = find_equilibrium(model, {}, load).state;

  NeedleState state = make_needle_state(model, {});
  NeedleMotion motion(model, 1e-3, 1);
  const double lambda = 1;
  for (int i = 0; i < 1000; ++i) {
    motion.begin(state, {});
    motion.linearize(state);
    motion.clear_rows();
    motion.add_row(load.beam, load.force);
    motion.correct({&lambda, 1});
    motion.commit(state);
  }
  CHECK((state.x - expected.x).cwiseAbs().maxCoeff() < 1e-8);
  CHECK((motion.base_reaction().head<3>() + force).norm() < 1e-9 * force.norm());
}

// The largest change of a position (m) or of an orientation's entry over `ticks` ticks without a command.
double largest_change(const Pose& base, int ticks) {
  const NeedleModel model = make_needle_model(NeedleBody{}, Vector3::Zero());
  const NeedleState start = make_needle_state(model, base);
  NeedleState state = start;
  NeedleMotion motion(model, 1e-3, 1);
  for (int i = 0; i < ticks; ++i) tick(motion, state, base);
  double largest = (state.x - start.x).cwiseAbs().maxCoeff();
  for (std::size_t i = 0; i < state.q.size(); ++i)
    largest = std::max(largest, (state.q[i].coeffs() - start.q[i].coeffs()).cwiseAbs().maxCoeff());
  return largest;
}

TEST_CASE("with nothing commanded nothing moves, bit for bit along the axes") { CHECK(largest_change({}, 1000) == 0); }

TEST_CASE("with nothing commanded a needle askew trembles by rounding alone and does not drift" *
          doctest::test_suite("gate")) {
  const Pose base{{0.1, 0.2, -0.3}, rotation_exp({0.3, -0.8, 1.9})};
  CHECK(largest_change(base, 1) < 1e-13);
  CHECK(largest_change(base, 20000) < 1e-13);
}

TEST_CASE("a bent needle at rest under no load change stays within rounding for a long time") {
  const Vector3 gravity(0, 0, -9.81);
  const NeedleModel model = make_needle_model(NeedleBody{}, gravity);
  const Pose base{{0.1, 0.2, -0.3}, rotation_exp({0.3, -0.8, 1.9})};
  const NeedleState start = find_equilibrium(model, base, tip_load(model, Vector3::Zero(), Vector3::Zero())).state;
  NeedleState state = start;
  NeedleMotion motion(model, 1e-3, 1);
  for (int i = 0; i < 5000; ++i) tick(motion, state, base);
  CHECK((state.x - start.x).cwiseAbs().maxCoeff() < 1e-10);
}

TEST_CASE("many turns of the base leave a straight needle straight and, at steady spin, unstressed") {
  const NeedleModel model = make_needle_model(NeedleBody{}, Vector3::Zero());
  const Pose base{{0.1, 0.2, -0.3}, rotation_exp({0.3, -0.8, 1.9})};
  NeedleState state = make_needle_state(model, base);
  NeedleMotion motion(model, 1e-3, 1);
  Pose spun = base;
  for (int i = 1; i <= 2000; ++i) {
    spun.orientation = (base.orientation * rotation_exp({0.3 * i, 0, 0})).normalized();  // 95 turns in all
    tick(motion, state, spun);
  }
  for (int i = 0; i < model.nodes(); ++i) {
    CHECK((state.x.col(i) - base * Vector3(i * model.beam_length(), 0, 0)).norm() < 1e-10);
    CHECK(rotation_log(state.q[i] * spun.orientation.conjugate()).norm() < 1e-8);
  }
  // EA is 1.6e5 N: rounding of the beams' lengths alone makes 1e-8 N.
  CHECK(motion.base_reaction().head<3>().norm() < 1e-9);
  CHECK(motion.base_reaction().tail<3>().norm() < 1e-9);
}

TEST_CASE("in every tick the holder and the load carry inertia less weight") {
  NeedleBody body;
  body.beams = 20;
  body.material.rayleigh_mass = 3;
  const NeedleModel model = make_needle_model(body, {0, 0, -9.81});
  NeedleState state = make_needle_state(model, {});
  NeedleMotion motion(model, 1e-3, 1);
  Random random(2);
  for (int i = 0; i < 50; ++i) {
    const Pose base{random.vector(1e-4), rotation_exp(random.vector(1e-3))};
    const double lambda = random.uniform(-1, 1);
    const Vector3 n = random.direction();
    const double s = random.uniform(0, model.length);
    motion.begin(state, base);
    for (int iteration = 0; iteration < 8; ++iteration) {
      motion.linearize(state);
      motion.clear_rows();
      const CurvePoint point = curve_point(model, motion.shape(), s);
      motion.add_row(point.beam, curve_force(motion.shape(), point, n));
      motion.correct({&lambda, 1});
    }
    const Vector3 sum = motion.base_reaction().head<3>() + lambda * n;
    CHECK((sum - motion.inertia_less_weight(state)).norm() < 1e-9 * (1 + sum.norm()));
    motion.commit(state);
  }
}

TEST_CASE("rows: free displacement and compliance predict what the correction does") {
  const NeedleModel model = make_needle_model(NeedleBody{}, {0, 0, -9.81});
  NeedleState state = make_needle_state(model, {});
  NeedleMotion motion(model, 1e-3, 6);
  tick(motion, state, {});
  motion.begin(state, {{1e-4, 2e-4, 0}, Quaternion::Identity()});
  motion.linearize(state);
  motion.clear_rows();

  // At nodes the rows are linear in dq: no error but rounding.
  Random random(3);
  const int nodes[6] = {1, 2, 20, 20, 49, 50};
  Vector3 n[6];
  VectorX lambda = random.matrix(6, 1);
  for (int r = 0; r < 6; ++r) {
    n[r] = random.direction();
    Vector12 force = Vector12::Zero();
    force.segment<3>(6) = n[r];
    REQUIRE(motion.add_row(nodes[r] - 1, force) == r);
  }
  MatrixX W = MatrixX::Zero(6, 6);
  const int places[6] = {0, 1, 2, 3, 4, 5};
  motion.add_compliances(places, W);
  VectorX expected = W.selfadjointView<Eigen::Lower>() * lambda;
  for (int r = 0; r < 6; ++r) expected[r] += motion.free_displacement(r);
  const Matrix3X before = motion.shape().x;
  motion.correct({lambda.data(), 6});
  for (int r = 0; r < 6; ++r) {
    const double moved = n[r].dot(motion.shape().x.col(nodes[r]) - before.col(nodes[r]));
    CHECK(std::abs(moved - expected[r]) < 1e-12 * expected.norm());
  }
}

TEST_CASE("an unstable tangent is replaced, and said so") {
  NeedleBody body = bench_body();
  body.beams = 4;
  const NeedleModel model = make_needle_model(body, Vector3::Zero());
  NeedleState state = make_needle_state(model, {});
  for (int i = 1; i < model.nodes(); ++i) state.x.col(i) *= 0.97;  // far beyond buckling
  NeedleMotion motion(model, 1, 1);
  motion.begin(state, {});
  CHECK_FALSE(motion.linearize(state));
  motion.correct({});
  CHECK(motion.finite());
}

}  // namespace
}  // namespace acus
