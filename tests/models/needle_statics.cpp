// SPDX-License-Identifier: GPL-3.0-or-later
// Needles at rest under load, against the elastica, the circular arc, and the balance of forces and moments.
#include <doctest/doctest.h>

#include "server/engine/math/random.h"
#include "server/engine/math/rotation.h"
#include "tests/models/bench_needle.h"

namespace acus {
namespace {

constexpr double kPi = std::numbers::pi;

// The inextensible elastica of length 1, clamped horizontally, with a vertical load P L²/EI = p at its end:
// theta'' = -p cos(theta), theta(0) = 0, theta'(1) = 0. Shooting on theta'(0), Runge-Kutta of order four.
struct Elastica {
  double x = 0, y = 0, theta = 0;  // of the end

  explicit Elastica(double p) {
    double low = 0, high = p;
    for (int i = 0; i < 60; ++i) {
      const double middle = (low + high) / 2;
      (shoot(p, middle) > 0 ? high : low) = middle;
    }
    shoot(p, low);
  }

 private:
  // Returns theta'(1).
  double shoot(double p, double curvature) {
    constexpr int kSteps = 1000;
    constexpr double h = 1.0 / kSteps;
    using State = Eigen::Vector4d;  // x, y, theta, theta'
    const auto slope = [p](const State& s) { return State(std::cos(s[2]), std::sin(s[2]), s[3], -p * std::cos(s[2])); };
    State s(0, 0, 0, curvature);
    for (int i = 0; i < kSteps; ++i) {
      const State k1 = slope(s), k2 = slope(s + h / 2 * k1), k3 = slope(s + h / 2 * k2), k4 = slope(s + h * k3);
      s += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
    }
    x = s[0], y = s[1], theta = s[2];
    return s[3];
  }
};

// Somewhere in the world, so that nothing depends on the axes.
const Pose kBase{{0.1, -0.2, 0.3}, rotation_exp({0.5, -1.1, 2.0})};

Vector3 in_base(const Vector3& world) { return kBase.orientation.conjugate() * (world - kBase.position); }

TEST_CASE("the shooting oracle knows the tabulated elastica") {
  // Bisshopp and Drucker 1945: P L²/EI = 1 and 10.
  CHECK(Elastica(1).y == doctest::Approx(0.30172).epsilon(1e-4));
  CHECK(Elastica(1).x == doctest::Approx(1 - 0.05643).epsilon(1e-4));
  CHECK(Elastica(10).y == doctest::Approx(0.81061).epsilon(1e-4));
}

TEST_CASE("a cantilever with a transverse load at its tip follows the elastica") {
  const NeedleModel model = make_needle_model(bench_body(), Vector3::Zero());
  for (const double p : {0.1, 1.0, 3.7}) {
    const Elastica oracle(p);
    const double force = p * model.stiffness.bending / (model.length * model.length);
    const NeedleLoad load = tip_load(model, kBase.orientation * Vector3(0, 0, -force), Vector3::Zero());
    const Equilibrium found = find_equilibrium(model, kBase, load);
    const Vector3 tip = in_base(found.state.x.col(model.beams)) / model.length;
    const Vector3 tangent = kBase.orientation.conjugate() * (found.state.q.back() * Vector3::UnitX());
    CAPTURE(p);
    CHECK(std::abs(tip.x() - oracle.x) < 4e-4 * oracle.y);
    CHECK(std::abs(tip.y()) < 1e-9);
    CHECK(tip.z() == doctest::Approx(-oracle.y).epsilon(2e-4).scale(0));
    CHECK(std::atan2(-tangent.z(), tangent.x()) == doctest::Approx(oracle.theta).epsilon(2e-4).scale(0));
  }
  CHECK(Elastica(3.7).theta > 58 * kPi / 180);
}

TEST_CASE("the elastica is approached with the square of the beams' length") {
  double error[2];
  for (int i = 0; i < 2; ++i) {
    NeedleBody body = bench_body();
    body.beams = i == 0 ? 10 : 20;
    const NeedleModel model = make_needle_model(body, Vector3::Zero());
    const double force = 3.7 * model.stiffness.bending / (model.length * model.length);
    const Equilibrium found = find_equilibrium(model, {}, tip_load(model, {0, force, 0}, Vector3::Zero()));
    const Elastica oracle(3.7);
    error[i] = (found.state.x.col(model.beams) / model.length - Vector3(oracle.x, oracle.y, 0)).norm();
  }
  CHECK(error[0] < 0.005);
  CHECK(error[0] / error[1] == doctest::Approx(4).epsilon(0.08).scale(0));
}

TEST_CASE("a couple at the tip bends the needle to a circular arc") {
  // In a plane through the axes: a dead couple has no energy for turns out of its plane, and Newton's method on the
  // symmetric tangent would have nothing to hold on to there.
  const NeedleModel model = make_needle_model(bench_body(), Vector3::Zero());
  for (const double angle : {0.5, kPi / 2, kPi, 2 * kPi}) {
    const double couple = angle * model.stiffness.bending / model.length;
    const Equilibrium found = find_equilibrium(model, {}, tip_load(model, Vector3::Zero(), {0, 0, couple}), 20);
    const double radius = model.length / angle;
    for (int i = 0; i < model.nodes(); ++i) {
      const double turned = angle * i / model.beams;
      const Vector3 arc(radius * std::sin(turned), radius * (1 - std::cos(turned)), 0);
      CHECK((found.state.x.col(i) - arc).norm() < 0.005 * model.length);
    }
    CHECK(found.reaction[5] == doctest::Approx(-couple).epsilon(1e-7));
  }
}

TEST_CASE("a tube bends and twists by its own second moments") {
  NeedleBody body = bench_body();
  body.outer_diameter = 1.2e-3;
  body.inner_diameter = 0.9e-3;
  const NeedleModel model = make_needle_model(body, Vector3::Zero());
  const double e = body.material.young_modulus, d4 = std::pow(1.2e-3, 4) - std::pow(0.9e-3, 4);
  const double bending = e * kPi / 64 * d4, torsion = e / 2.6 * kPi / 32 * d4;
  CHECK(model.stiffness.axial == doctest::Approx(e * kPi / 4 * (1.2e-3 * 1.2e-3 - 0.9e-3 * 0.9e-3)));
  const double mass = 7800 * kPi / 4 * (1.2e-3 * 1.2e-3 - 0.9e-3 * 0.9e-3) * body.length;
  CHECK(model.mass.sum() == doctest::Approx(mass).epsilon(1e-9).scale(0));

  const double force = 0.01;
  const Equilibrium bent = find_equilibrium(model, {}, tip_load(model, {0, force, 0}, Vector3::Zero()));
  const double deflection = force * std::pow(body.length, 3) / (3 * bending);
  CHECK(bent.state.x(1, model.beams) == doctest::Approx(deflection).epsilon(9e-5).scale(0));

  const double couple = 0.01;
  const Equilibrium twisted = find_equilibrium(model, {}, tip_load(model, Vector3::Zero(), {couple, 0, 0}));
  CHECK(rotation_log(twisted.state.q.back()).x() == doctest::Approx(couple * body.length / torsion).epsilon(1e-9));
}

TEST_CASE("in equilibrium the holder carries the load, its moment and its torque") {
  const NeedleModel model = make_needle_model(bench_body(), Vector3::Zero());
  Random random(1);
  for (int repeat = 0; repeat < 5; ++repeat) {
    const Vector3 force = random.vector(0.8), couple = random.vector(0.05);
    const Equilibrium found = find_equilibrium(model, kBase, tip_load(model, force, couple));
    const Vector3 arm = found.state.x.col(model.beams) - kBase.position;
    const Vector3 moment = arm.cross(force) + couple;
    CHECK((found.reaction.head<3>() + force).norm() < 1e-7 * force.norm());
    CHECK((found.reaction.tail<3>() + moment).norm() < 1e-7 * moment.norm());
  }
}

TEST_CASE("a load on the first beam reaches the holder too, the part on the held node included") {
  const NeedleModel model = make_needle_model(bench_body(), Vector3::Zero());
  const NeedleState start = make_needle_state(model, kBase);
  NeedleMotion motion(model, 1e4, 1);
  motion.begin(start, kBase);
  const double s = 0.4 * model.beam_length(), lambda = 0.5;
  const Vector3 n = kBase.orientation * Vector3(0.2, 0.8, -0.3);
  const CurvePoint point = curve_point(model, motion.shape(), s);
  for (int iteration = 0; iteration < 10; ++iteration) {
    motion.linearize(start);
    motion.clear_rows();
    motion.add_row(0, curve_force(motion.shape(), curve_point(model, motion.shape(), s), n));
    motion.correct({&lambda, 1});
  }
  const Vector3 moment = (point.position - kBase.position).cross(lambda * n);
  CHECK((motion.base_reaction().head<3>() + lambda * n).norm() < 1e-7);
  CHECK((motion.base_reaction().tail<3>() + moment).norm() < 1e-5 * moment.norm());
}

TEST_CASE("the holder carries the weight") {
  const Vector3 gravity(0, 0, -9.81);
  NeedleBody body = bench_body();
  body.length = 0.5;  // long and thin: it sags
  body.outer_diameter = 0.6e-3;
  const NeedleModel model = make_needle_model(body, gravity);
  const Equilibrium found = find_equilibrium(model, {}, tip_load(model, Vector3::Zero(), Vector3::Zero()));
  CHECK((found.reaction.head<3>() + model.mass.sum() * gravity).norm() < 1e-8 * model.mass.sum() * 9.81);
  Vector3 moment = Vector3::Zero();
  for (int i = 0; i < model.nodes(); ++i)
    moment += Vector3(found.state.x.col(i)).cross(Vector3(model.mass[i] * gravity));
  CHECK((found.reaction.tail<3>() + moment).norm() < 1e-7 * moment.norm());
  CHECK(found.state.x(2, model.beams) < -0.01);
}

// Turned at its base by `turn` and pressed by u² EI/L² at a tip that nothing but two rows keeps on the x axis: how many
// linearisations it takes until the base resists by EI/L u² sin u/(sin u - u cos u) for each radian, the beam-column
// with its far end pinned. A free tip gives way at u = pi/2, a pinned one at 4.49.
int steps_until_right(double u, int held) {
  constexpr double kTurn = 1e-3;
  const NeedleModel model = make_needle_model(bench_body(), Vector3::Zero());
  const double L = model.length, EI = model.stiffness.bending, press = u * u * EI / (L * L);
  const double expected = EI / L * u * u * std::sin(u) / (std::sin(u) - u * std::cos(u)) * kTurn;
  NeedleState state = make_needle_state(model, Pose());
  NeedleMotion motion(model, 1e4, 3);
  motion.begin(state, {Vector3::Zero(), rotation_exp({0, 0, kTurn})});
  for (int step = 1; step < 100; ++step) {
    const bool exact = motion.linearize(state, held);
    CHECK(exact == (step == 1 || u < kPi / 2));  // in the first one nothing presses yet
    motion.clear_rows();
    for (int axis = 0; axis < 3; ++axis)
      motion.add_row(model.beams - 1, tip_load(model, Vector3::Unit(axis), Vector3::Zero()).force);
    MatrixX W = MatrixX::Zero(3, 3);
    const int places[] = {0, 1, 2};
    motion.add_compliances(places, W);
    W.triangularView<Eigen::StrictlyUpper>() = W.transpose();
    Vector3 aside = motion.shape().x.rightCols<1>(), lambda(-press, 0, 0);
    for (int axis = 1; axis < 3; ++axis) aside[axis] += motion.free_displacement(axis) - W(axis, 0) * press;
    lambda.tail<2>() = -W.bottomRightCorner<2, 2>().inverse() * aside.tail<2>();
    motion.correct({lambda.data(), 3});
    if (std::abs(motion.base_reaction()[5] / expected - 1) < 0.01) return step;
  }
  return 100;
}

TEST_CASE("a needle that is pressed by more than a free tip bears is found at once where its tip is held") {
  CHECK(steps_until_right(1, 1) <= 3);
  for (const double u : {1.8, 2.5, 3.0, 3.5, 4.0}) {
    CAPTURE(u);
    CHECK(steps_until_right(u, 1) <= 4);
    CHECK(steps_until_right(u, 0) >= steps_until_right(u, 1));
  }
  CHECK(steps_until_right(4, 0) > 15);  // by the material part alone
}

}  // namespace
}  // namespace acus
