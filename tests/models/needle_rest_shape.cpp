// SPDX-License-Identifier: GPL-3.0-or-later
// Needles that are curved when unloaded: the arc, its freedom from stress, derivatives, and deflection against curved
// beam theory.
#include <doctest/doctest.h>

#include <numbers>

#include "server/engine/math/random.h"
#include "server/engine/math/rotation.h"
#include "tests/models/bench_needle.h"

namespace acus {
namespace {

constexpr double kPi = std::numbers::pi;

// Somewhere in the world, so that nothing depends on the axes.
const Pose kBase{{0.1, -0.2, 0.3}, rotation_exp({0.5, -1.1, 2.0})};

// 0.15 m long, bent over all its length or over its end alone. An end of 0.052 m starts inside a beam of 3 mm.
NeedleBody bent_body(double curvature, std::optional<double> curved_length = {}) {
  NeedleBody body = bench_body();
  body.curvature = curvature;
  body.curved_length = curved_length;
  return body;
}

NeedleModel bent(double curvature, std::optional<double> curved_length = {}) {
  return make_needle_model(bent_body(curvature, curved_length), Vector3::Zero());
}

std::vector<NeedleModel> bent_needles() {
  return {bent(5), bent(-8), bent(12, 0.052), bent(-12, 0.06), bent(30, 1e-4)};
}

NeedleShape shape_of(const NeedleState& state) {
  NeedleShape shape{state.x, {}};
  for (const Quaternion& q : state.q) shape.frames.push_back(q.toRotationMatrix());
  return shape;
}

TEST_CASE("a curved needle lies on a straight line and then on a circle that touches it") {
  const double curvature = 12, straight = 0.098, radius = 1 / curvature;
  const NeedleModel model = bent(curvature, 0.052);
  CHECK(model.straight_beams == 32);
  for (int i = 0; i <= 150; ++i) {
    const double s = 0.001 * i;
    const Pose pose = rest_pose(model, s);
    const double angle = std::max(s - straight, 0.0) * curvature;
    const Vector3 expected(std::min(s, straight) + radius * std::sin(angle), radius * (1 - std::cos(angle)), 0);
    CHECK((pose.position - expected).norm() < 1e-15);
    CHECK((pose.orientation * Vector3::UnitX() - Vector3(std::cos(angle), std::sin(angle), 0)).norm() < 1e-15);
    CHECK((pose.orientation * Vector3::UnitZ() - Vector3::UnitZ()).norm() < 1e-15);
  }
}

TEST_CASE("a curvature that vanishes leaves the straight needle, one of opposite sign mirrors it") {
  const NeedleState straight = make_needle_state(bent(0), kBase);
  CHECK((make_needle_state(bent(1e-300), kBase).x - straight.x).cwiseAbs().maxCoeff() < 1e-15);
  CHECK((make_needle_state(bent(1e-9), kBase).x - straight.x).cwiseAbs().maxCoeff() < 1e-10);
  const Matrix3X left = make_needle_state(bent(7, 0.1), {}).x, right = make_needle_state(bent(-7, 0.1), {}).x;
  CHECK(left.row(0) == right.row(0));
  CHECK(left.row(1) == -right.row(1));
  CHECK(left(1, 50) > 0.01);
}

TEST_CASE("a needle curved over no part has the beams of a straight one") {
  const NeedleModel model = bent(0, 0.05);
  CHECK(model.straight_beams == model.beams);
  CHECK(model.curved.empty());
}

TEST_CASE("a curved needle laid out at rest bears no stress") {
  for (const NeedleModel& model : bent_needles()) {
    for (const Pose& base : {Pose{}, kBase}) {
      const NeedleShape shape = shape_of(make_needle_state(model, base));
      for (int e = 0; e < model.beams; ++e) {
        const auto [stiffness, a, b] = needle_beam(model, shape, e);
        const Vector12 force = beam_forces(stiffness, a, b);
        // A beam is 3 mm long and 0.4 m from the origin: rounding of its ends alone strains and turns it by 4e-14.
        const double couple = stiffness.bending / stiffness.length;
        CHECK(force.segment<3>(0).norm() < 1e-12 * (stiffness.axial + couple / stiffness.length));
        CHECK(force.segment<3>(3).norm() < 1e-12 * couple);
        CHECK(force.segment<3>(9).norm() < 1e-12 * couple);
      }
    }
  }
}

TEST_CASE("the curve between the nodes of a curved needle at rest is the arc") {
  for (const NeedleModel& model : bent_needles()) {
    const NeedleShape shape = shape_of(make_needle_state(model, {}));
    for (int i = 0; i <= 400; ++i) {
      const double s = model.length * i / 400;
      const CurvePoint point = curve_point(model, shape, s);
      const Pose exact = rest_pose(model, s);
      // A beam in which the bend starts departs by a few per cent of curvature x length²; whole arcs far less.
      CHECK((point.position - exact.position).norm() < 0.02 * std::abs(model.curvature) * 9e-6);
      CHECK((point.tangent - exact.orientation * Vector3::UnitX()).norm() < 0.15 * std::abs(model.curvature) * 3e-3);
    }
  }
}

// Four beams, of which one is straight and one bends from its middle on; moved, bent and twisted at random.
struct DeformedNeedle {
  NeedleModel model;
  NeedleShape shape;

  explicit DeformedNeedle(unsigned seed) {
    NeedleBody body = bent_body(2, 0.5);
    body.length = 0.8;
    body.beams = 4;
    body.outer_diameter = 0.2;  // axial and bending stiffness of the same order, so that differences resolve both
    body.material.young_modulus = 100;
    model = make_needle_model(body, Vector3::Zero());
    shape = shape_of(make_needle_state(model, kBase));
    Random random(seed);
    for (int i = 0; i < 6 * model.nodes(); ++i) move(i, random.uniform(-1, 1) * (i % 6 < 3 ? 0.02 : 0.3));
  }

  void move(int coordinate, double by) {
    const int node = coordinate / 6;
    const Vector3 step = by * Vector3::Unit(coordinate % 3);
    if (coordinate % 6 < 3) {
      shape.x.col(node) += step;
    } else {
      Matrix3& frame = shape.frames[static_cast<std::size_t>(node)];
      frame = rotation_exp(step).toRotationMatrix() * frame;
    }
  }

  // Of one beam after the motion (x1, theta1, x2, theta2).
  double energy(const Vector12& dq, int beam) const {
    NeedleShape moved = shape;
    for (int k = 0; k < 2; ++k) {
      moved.x.col(beam + k) += dq.segment<3>(6 * k);
      Matrix3& frame = moved.frames[static_cast<std::size_t>(beam + k)];
      frame = rotation_exp(dq.segment<3>(6 * k + 3)).toRotationMatrix() * frame;
    }
    const auto [stiffness, a, b] = needle_beam(model, moved, beam);
    return beam_energy(stiffness, a, b);
  }
};

TEST_CASE("forces of curved beams are the gradient of their energy in the nodes' own motions") {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const DeformedNeedle needle(seed);
    REQUIRE(needle.model.straight_beams == 1);
    for (int beam = 0; beam < 4; ++beam) {
      const auto [stiffness, a, b] = needle_beam(needle.model, needle.shape, beam);
      const Vector12 forces = beam_forces(stiffness, a, b);
      for (int i = 0; i < 12; ++i) {
        const Vector12 step = 1e-5 * Vector12::Unit(i);
        const double difference = (needle.energy(step, beam) - needle.energy(-step, beam)) / 2e-5;
        CHECK(std::abs(difference - forces[i]) < 1e-7 * forces.norm());
      }
    }
  }
}

TEST_CASE("tangents of curved beams are the Hessian of their energy in the nodes' own motions") {
  const DeformedNeedle needle(6);
  for (int beam = 0; beam < 4; ++beam) {
    const auto [stiffness, a, b] = needle_beam(needle.model, needle.shape, beam);
    const Matrix12 k = beam_tangent(stiffness, a, b);
    const auto second_difference = [&](int i, int j, double h) {
      const Vector12 di = h * Vector12::Unit(i), dj = h * Vector12::Unit(j);
      const double alike = needle.energy(di + dj, beam) + needle.energy(-di - dj, beam);
      const double opposed = needle.energy(di - dj, beam) + needle.energy(dj - di, beam);
      return (alike - opposed) / (4 * h * h);
    };
    for (int i = 0; i < 12; ++i)
      for (int j = 0; j <= i; ++j) {
        // Richardson extrapolation takes the error of order h² out.
        const double value = (4 * second_difference(i, j, 1e-3) - second_difference(i, j, 2e-3)) / 3;
        CHECK(std::abs(value - k(i, j)) < 1e-7 * k.cwiseAbs().maxCoeff());
      }
  }
}

Vector3 tip_deflection(const NeedleModel& model, const Vector3& force) {
  const Vector3 rest = make_needle_state(model, {}).x.col(model.beams);
  return find_equilibrium(model, {}, tip_load(model, force, Vector3::Zero()), 1).state.x.col(model.beams) - rest;
}

TEST_CASE("a slightly curved needle gives way to a small load like the straight one") {
  const Vector3 force(0, 2e-3, -3e-3);
  const Vector3 straight = tip_deflection(bent(0), force);
  CHECK((tip_deflection(bent(0.3), force) - straight).norm() < 0.03 * straight.norm());
  CHECK((tip_deflection(bent(0.003), force) - straight).norm() < 3e-4 * straight.norm());
}

TEST_CASE("a quarter circle gives way to a small load as curved beam theory says") {
  // Castigliano: in the plane the moment is F R cos(phi) for a force along the clamped tangent; across it bending is
  // F R cos(phi) and torsion F R (1 - sin(phi)).
  const NeedleModel model = bent(kPi / 2 / 0.15);
  const double radius = 0.15 / (kPi / 2), force = 1e-3, unit = force * std::pow(radius, 3);
  const double bending = model.stiffness.bending, torsion = model.stiffness.torsion;
  CHECK(tip_deflection(model, {force, 0, 0}).x() == doctest::Approx(unit * kPi / 4 / bending).epsilon(2e-3).scale(0));
  CHECK(tip_deflection(model, {0, 0, force}).z() ==
        doctest::Approx(unit * (kPi / 4 / bending + (3 * kPi / 4 - 2) / torsion)).epsilon(5e-4).scale(0));
}

TEST_CASE("a couple that undoes the curvature straightens the needle") {
  const double curvature = 6;
  const NeedleModel model = bent(curvature);
  const Vector3 couple(0, 0, -curvature * model.stiffness.bending);
  const Equilibrium found = find_equilibrium(model, {}, tip_load(model, Vector3::Zero(), couple), 20);
  CHECK(found.state.x.row(1).cwiseAbs().maxCoeff() < 1e-4 * model.length);
  CHECK(found.state.x(0, model.beams) == doctest::Approx(model.length).epsilon(4e-5).scale(0));
}

TEST_CASE("spinning the base spins the arc, unstressed") {
  const NeedleModel model = bent(10, 0.052);
  NeedleState state = make_needle_state(model, kBase);
  NeedleMotion motion(model, 10, 1);  // slow: centrifugal forces play no part
  Pose spun = kBase;
  for (int tick = 1; tick <= 200; ++tick) {
    spun.orientation = (kBase.orientation * rotation_exp({0.3 * tick, 0, 0})).normalized();  // nine turns in all
    motion.begin(state, spun);
    motion.linearize(state);
    motion.clear_rows();
    motion.correct({});
    motion.commit(state);
  }
  for (int i = 0; i < model.nodes(); ++i) {
    const Pose rest = rest_pose(model, i * model.beam_length());
    CHECK((state.x.col(i) - spun * rest.position).norm() < 1e-8);
    const Quaternion expected = spun.orientation * rest.orientation;
    CHECK(rotation_log(state.q[static_cast<std::size_t>(i)] * expected.conjugate()).norm() < 3e-9);
  }
  CHECK(motion.base_reaction().norm() < 4e-9);
}

TEST_CASE("with nothing commanded a curved needle trembles by rounding alone and does not drift") {
  NeedleBody body = bent_body(12, 0.052);
  body.material.rayleigh_stiffness = 1e-3;
  const NeedleModel model = make_needle_model(body, Vector3::Zero());
  const NeedleState start = make_needle_state(model, kBase);
  NeedleState state = start;
  NeedleMotion motion(model, 1e-3, 1);
  for (int tick = 0; tick < 5000; ++tick) {
    motion.begin(state, kBase);
    motion.linearize(state);
    motion.clear_rows();
    motion.correct({});
    motion.commit(state);
  }
  CHECK((state.x - start.x).cwiseAbs().maxCoeff() < 1e-13);
}

}  // namespace
}  // namespace acus
