// SPDX-License-Identifier: GPL-3.0-or-later
// The needle's curve between its nodes: continuity, tangent, and the forces that belong to it.
#include <doctest/doctest.h>

#include "server/engine/math/random.h"
#include "server/engine/math/rotation.h"
#include "tests/models/bench_needle.h"

namespace acus {
namespace {

NeedleModel curve_model() {
  NeedleBody body = bench_body();
  body.beams = 8;
  body.length = 0.8;
  return make_needle_model(body, Vector3::Zero());
}

// A gently winding needle.
NeedleShape winding(const NeedleModel& model, unsigned seed) {
  Random random(seed);
  NeedleShape shape;
  shape.x.setZero(3, model.nodes());
  Quaternion q = random.rotation();
  for (int i = 0; i < model.nodes(); ++i) {
    shape.frames.push_back(q.toRotationMatrix());
    if (i + 1 == model.nodes()) break;
    const Quaternion next = rotation_exp(random.vector(0.2)) * q;
    const Vector3 along = (q * Vector3::UnitX() + next * Vector3::UnitX()).normalized();
    shape.x.col(i + 1) = shape.x.col(i) + model.beam_length() * along;
    q = next;
  }
  return shape;
}

TEST_CASE("the curve passes through the nodes with their tangents, and runs on beyond the ends") {
  const NeedleModel model = curve_model();
  const NeedleShape shape = winding(model, 1);
  for (int i = 0; i < model.nodes(); ++i) {
    const CurvePoint c = curve_point(model, shape, i * model.beam_length());
    CHECK((c.position - shape.x.col(i)).norm() < 1e-15);
    CHECK((c.tangent - shape.frames[static_cast<std::size_t>(i)].col(0)).norm() < 1e-14);
  }
  const CurvePoint before = curve_point(model, shape, -0.05);
  CHECK((before.position - (shape.x.col(0) - 0.05 * shape.frames.front().col(0))).norm() < 1e-15);
  CHECK(before.beam == 0);
  const CurvePoint after = curve_point(model, shape, model.length + 0.3);
  CHECK((after.position - (shape.x.col(8) + 0.3 * shape.frames.back().col(0))).norm() < 1e-14);
  CHECK(after.beam == model.beams - 1);
}

TEST_CASE("position and tangent are continuous from beam to beam") {
  const NeedleModel model = curve_model();
  const NeedleShape shape = winding(model, 2);
  for (int i = 0; i < model.nodes(); ++i) {
    const double s = i * model.beam_length();
    const CurvePoint before = curve_point(model, shape, s - 1e-9), after = curve_point(model, shape, s + 1e-9);
    CHECK((after.position - before.position).norm() < 3e-9);
    CHECK((after.tangent - before.tangent).norm() < 1e-7);
  }
}

TEST_CASE("the tangent is the direction of the curve") {
  const NeedleModel model = curve_model();
  const NeedleShape shape = winding(model, 3);
  Random random(4);
  for (int repeat = 0; repeat < 50; ++repeat) {
    const double s = random.uniform(-0.1, model.length + 0.1);
    const Vector3 difference =
        curve_point(model, shape, s + 1e-6).position - curve_point(model, shape, s - 1e-6).position;
    CHECK((difference.normalized() - curve_point(model, shape, s).tangent).norm() < 1e-9);
    CHECK(difference.norm() == doctest::Approx(2e-6).epsilon(0.01).scale(0));
  }
}

TEST_CASE("the generalised force of a point is the derivative of its position") {
  const NeedleModel model = curve_model();
  Random random(5);
  for (int repeat = 0; repeat < 30; ++repeat) {
    const NeedleShape shape = winding(model, 100 + static_cast<unsigned>(repeat));
    const double s = random.uniform(0, model.length);
    const Vector3 n = random.direction();
    const CurvePoint point = curve_point(model, shape, s);
    const Vector12 force = curve_force(shape, point, n);
    const auto position_along_n = [&](int coordinate, double step) {
      NeedleShape moved = shape;
      const int node = point.beam + coordinate / 6;
      const Vector3 by = step * Vector3::Unit(coordinate % 3);
      if (coordinate % 6 < 3) {
        moved.x.col(node) += by;
      } else {
        moved.frames[static_cast<std::size_t>(node)] = rotation_exp(by) * shape.frames[static_cast<std::size_t>(node)];
      }
      return n.dot(curve_point(model, moved, s).position);
    };
    for (int i = 0; i < 12; ++i) {
      const double difference = (position_along_n(i, 1e-5) - position_along_n(i, -1e-5)) / 2e-5;
      CHECK(std::abs(difference - force[i]) < 1e-9);
    }
  }
}

TEST_CASE("a couple on the curve keeps its size and goes with the rotation between the nodes") {
  const NeedleModel model = curve_model();
  const NeedleShape shape = winding(model, 7);
  const Vector3 couple(0.1, -0.2, 0.3);
  const Vector12 f = curve_torque(curve_point(model, shape, 3.25 * model.beam_length()), couple);
  CHECK(f.segment<3>(0).norm() == 0);
  CHECK(f.segment<3>(6).norm() == 0);
  CHECK((f.segment<3>(3) - 0.75 * couple).norm() < 1e-14);
  CHECK((f.segment<3>(9) - 0.25 * couple).norm() < 1e-14);
}

TEST_CASE("forces along the curve keep their sum and, on a straight needle, their moment") {
  const NeedleModel model = curve_model();
  const NeedleState state = make_needle_state(model, {Vector3(1, 2, 3), rotation_exp({0.4, 0.5, 0.6})});
  NeedleMotion motion(model, 1e-3, 1);
  motion.begin(state, {state.x.col(0), state.q[0]});
  Random random(6);
  for (int repeat = 0; repeat < 20; ++repeat) {
    const CurvePoint point = curve_point(model, motion.shape(), random.uniform(0, model.length));
    const Vector3 n = random.direction();
    const Vector12 f = curve_force(motion.shape(), point, n);
    CHECK((f.segment<3>(0) + f.segment<3>(6) - n).norm() < 1e-14);
    const Vector3 a = motion.shape().x.col(point.beam), b = motion.shape().x.col(point.beam + 1);
    const Vector3 moment = f.segment<3>(3) + f.segment<3>(9) + a.cross(f.segment<3>(0)) + b.cross(f.segment<3>(6));
    CHECK((moment - point.position.cross(n)).norm() < 1e-13);
  }
}

}  // namespace
}  // namespace acus
