// SPDX-License-Identifier: GPL-3.0-or-later
// Rigid needles: nothing moves against the base, and the base carries rows, weight and inertia.
#include <doctest/doctest.h>

#include <limits>

#include "server/engine/math/random.h"
#include "server/engine/math/rotation.h"
#include "tests/models/bench_needle.h"

namespace acus {
namespace {

const Pose kBase{{0.1, -0.2, 0.3}, rotation_exp({0.5, -1.1, 2.0})};
const Vector3 kGravity(0, 0, -9.81);

NeedleModel rigid_needle(double curvature, const Vector3& gravity) {
  NeedleBody body = bench_body();
  body.curvature = curvature;
  body.curved_length = 0.07;
  return make_needle_model(body, gravity, true);
}

// One tick without rows.
void carry(NeedleMotion& motion, NeedleState& state, const Pose& base) {
  motion.begin(state, base);
  motion.linearize(state);
  motion.clear_rows();
  motion.correct({});
  motion.commit(state);
}

// What the nodes' weights pull on the base with: force and moment about it.
Vector6 weight(const NeedleModel& model, const NeedleShape& shape) {
  Vector6 sum = Vector6::Zero();
  for (int i = 0; i < model.nodes(); ++i) {
    const Vector3 force = model.mass[i] * model.gravity, arm = shape.x.col(i) - shape.x.col(0);
    sum.head<3>() += force;
    sum.tail<3>() += arm.cross(force);
  }
  return sum;
}

TEST_CASE("a rigid needle follows its base exactly, straight or curved, over many turns") {
  for (const double curvature : {0.0, 15.0}) {
    const NeedleModel model = rigid_needle(curvature, kGravity);
    NeedleState state = make_needle_state(model, kBase);
    NeedleMotion motion(model, 1e-3, 0);
    Random random(1);
    Pose base = kBase;
    for (int tick = 0; tick < 20000; ++tick) {
      base.position += random.vector(1e-4);
      base.orientation = (rotation_exp(random.vector(0.1)) * base.orientation).normalized();
      carry(motion, state, base);
    }
    const NeedleState exact = make_needle_state(model, base);
    CHECK((state.x - exact.x).cwiseAbs().maxCoeff() < 1e-12);
    CHECK(state.q.back().angularDistance(exact.q.back()) < 1e-12);
    CHECK(motion.finite());
  }
}

TEST_CASE("a rigid needle at rest hangs its weight and its rows on the base, moments included") {
  for (const double curvature : {0.0, 15.0}) {
    const NeedleModel model = rigid_needle(curvature, kGravity);
    const NeedleState state = make_needle_state(model, kBase);
    NeedleMotion motion(model, 1e-3, 5);
    motion.begin(state, kBase);
    CHECK(motion.linearize(state));
    motion.clear_rows();
    Random random(2);
    const VectorX lambda = random.matrix(5, 1);
    const double places[5] = {1e-3, 0.02, 0.08, 0.1234, model.length};
    Vector6 load = weight(model, motion.shape());
    for (int r = 0; r < 5; ++r) {
      const CurvePoint point = curve_point(model, motion.shape(), places[r]);
      const Vector3 n = random.direction(), arm = point.position - kBase.position;
      REQUIRE(motion.add_row(point.beam, curve_force(motion.shape(), point, n)) == r);
      load.head<3>() += lambda[r] * n;
      load.tail<3>() += lambda[r] * arm.cross(n);
    }
    motion.correct({lambda.data(), 5});
    CHECK((motion.base_reaction() + load).norm() < 1e-12);
  }
}

TEST_CASE("a couple on a rigid needle reaches the base as it is") {
  const NeedleModel model = rigid_needle(15, Vector3::Zero());
  const NeedleState state = make_needle_state(model, kBase);
  NeedleMotion motion(model, 1e-3, 1);
  motion.begin(state, kBase);
  motion.linearize(state);
  motion.clear_rows();
  const Vector3 couple(0.01, -0.02, 0.03);
  const double lambda = 2;
  motion.add_row(30, curve_torque(curve_point(model, motion.shape(), 0.0912), couple));
  motion.correct({&lambda, 1});
  CHECK(motion.base_reaction().head<3>().norm() < 1e-14);
  CHECK((motion.base_reaction().tail<3>() + lambda * couple).norm() < 1e-14);
}

TEST_CASE("no row moves a rigid needle") {
  const NeedleModel model = rigid_needle(15, kGravity);
  const NeedleState state = make_needle_state(model, kBase);
  NeedleMotion motion(model, 1e-3, 3);
  motion.begin(state, kBase);
  motion.linearize(state);
  motion.clear_rows();
  for (int r = 0; r < 3; ++r) {
    const CurvePoint point = curve_point(model, motion.shape(), 0.07 * r);
    motion.add_row(point.beam, curve_force(motion.shape(), point, Vector3::UnitY()));
  }
  for (int r = 0; r < 3; ++r) CHECK(motion.free_displacement(r) == 0);
  MatrixX W = MatrixX::Zero(3, 3);
  const int places[3] = {0, 1, 2};
  motion.add_compliances(places, W);
  CHECK(W.isZero(0));
  const Matrix3X before = motion.shape().x;
  const double lambda[3] = {100, -200, 300};
  CHECK(motion.correct(lambda) == 0);
  CHECK(motion.shape().x == before);
  CHECK(motion.finite());
}

TEST_CASE("forces that are not numbers do not pass for finite") {
  const NeedleModel model = rigid_needle(0, kGravity);
  const NeedleState state = make_needle_state(model, kBase);
  NeedleMotion motion(model, 1e-3, 1);
  motion.begin(state, kBase);
  motion.linearize(state);
  motion.clear_rows();
  motion.add_row(3, Vector12::Ones());
  const double lambda = std::numeric_limits<double>::quiet_NaN();
  motion.correct({&lambda, 1});
  CHECK_FALSE(motion.finite());
}

TEST_CASE("the base accelerates a rigid needle's mass") {
  const NeedleModel model = rigid_needle(15, kGravity);
  NeedleState state = make_needle_state(model, kBase);
  NeedleMotion motion(model, 1e-3, 0);
  const Vector3 acceleration(2, -3, 1);
  Pose base = kBase;
  for (int tick = 1; tick <= 20; ++tick) {
    base.position = kBase.position + 0.5 * acceleration * (1e-6 * tick * (tick + 1));
    carry(motion, state, base);
    Vector6 expected = -weight(model, motion.shape());
    for (int i = 0; i < model.nodes(); ++i) {
      const Vector3 force = model.mass[i] * acceleration, arm = motion.shape().x.col(i) - motion.shape().x.col(0);
      expected.head<3>() += force;
      expected.tail<3>() += arm.cross(force);
    }
    CHECK((motion.base_reaction() - expected).norm() < 1e-10);
  }
}

TEST_CASE("the base turns a rigid needle's moment of inertia and holds it on its circle") {
  const NeedleModel model = make_needle_model(bench_body(), Vector3::Zero(), true);
  double moment_of_inertia = 0, first_moment = 0;  // about an axis across, through the base
  for (int i = 0; i < model.nodes(); ++i) {
    const double r = i * model.beam_length();
    moment_of_inertia += model.mass[i] * r * r + model.inertia_transverse[i];
    first_moment += model.mass[i] * r;
  }
  NeedleState state = make_needle_state(model, {});
  constexpr double h = 1e-4;
  NeedleMotion motion(model, h, 0);
  const double acceleration = 50;  // rad/s²
  for (int tick = 1; tick <= 200; ++tick) {
    const double angle = 0.5 * acceleration * h * h * tick * (tick + 1);
    carry(motion, state, {Vector3::Zero(), rotation_exp({0, 0, angle})});
  }
  const Vector3 along = state.q[0] * Vector3::UnitX(), across = state.q[0] * Vector3::UnitY();
  const double spin = acceleration * h * 200;
  const Vector3 force = motion.base_reaction().head<3>();
  CHECK(motion.base_reaction()[5] == doctest::Approx(moment_of_inertia * acceleration).epsilon(5e-6).scale(0));
  CHECK(across.dot(force) == doctest::Approx(first_moment * acceleration).epsilon(5e-6).scale(0));
  CHECK(along.dot(force) == doctest::Approx(-first_moment * spin * spin).epsilon(2e-2).scale(0));
}

TEST_CASE("a rigid needle is the limit of a very stiff one") {
  NeedleBody body = bench_body();
  body.curvature = 10;
  body.beams = 10;
  body.material.young_modulus = 1e16;
  const NeedleModel rigid = make_needle_model(body, kGravity, true), stiff = make_needle_model(body, kGravity);
  const NeedleState state = make_needle_state(rigid, kBase);
  const Pose moved{kBase.position + Vector3(1e-5, 2e-5, -1e-5), rotation_exp({1e-4, 0, -1e-4}) * kBase.orientation};
  const double lambda = 0.7;
  Vector6 reaction[2];
  for (int i = 0; i < 2; ++i) {
    NeedleMotion motion(i == 0 ? rigid : stiff, 1e-2, 1);
    motion.begin(state, moved);
    motion.linearize(state);
    motion.clear_rows();
    const CurvePoint point = curve_point(rigid, motion.shape(), 0.11);
    motion.add_row(point.beam, curve_force(motion.shape(), point, Vector3(0.3, 0.9, -0.2)));
    motion.correct({&lambda, 1});
    reaction[i] = motion.base_reaction();
  }
  CHECK((reaction[0] - reaction[1]).norm() < 1e-5 * reaction[0].norm());
}

}  // namespace
}  // namespace acus
