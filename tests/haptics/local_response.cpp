// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/haptics/local_response.h"

#include <doctest/doctest.h>

using namespace acus::haptics;

namespace {

constexpr double kCouplingSpring = 400, kTwistSpring = 2, kSticking = 1000;  // N/m, N m/rad, N/m

// A tissue of k (N/m) along x that resists with `force` (N) at x = 0.
LocalModel pressed(double k, double force) {
  LocalModel model;
  model.felt.force[0] = -force;
  model.stiffness(0, 0) = -k;
  return model;
}

double felt(LocalResponse& response, double x) { return response({{{x, 0, 0}}, {}}).felt.force[0]; }

}  // namespace

TEST_CASE("without a model nothing is felt and the needle goes where the device goes") {
  LocalResponse response;
  const Pose device{{{1, 2, 3}}, rotation({{0.1, 0.2, 0.3}})};
  const auto answer = response(device);
  CHECK(norm(answer.felt.force) == 0);
  CHECK(norm(answer.proxy.position - device.position) == 0);
}

TEST_CASE("tissue and coupling are springs in series") {
  for (const double k : {1.0, 100.0, 400.0, 1e6}) {
    LocalResponse response(pressed(k, 0), kCouplingSpring, kTwistSpring, kSticking);
    const double series = k * kCouplingSpring / (k + kCouplingSpring);
    CHECK(felt(response, 1e-3) == doctest::Approx(-series * 1e-3));
    const auto answer = response({{{1e-3, 0, 0}}, {}});
    CHECK(answer.proxy.position[0] == doctest::Approx(series * 1e-3 / k));
  }
}

TEST_CASE("an elastic tissue is felt the same from an old model as from a new one") {
  LocalResponse old(pressed(300, 0.3), kCouplingSpring, kTwistSpring, kSticking);
  LocalModel later = pressed(300, 0.3 + 300 * 2e-3);
  later.base.position[0] = 2e-3;
  LocalResponse fresh(later, kCouplingSpring, kTwistSpring, kSticking);
  CHECK(felt(old, 5e-3) == doctest::Approx(felt(fresh, 5e-3)));
}

TEST_CASE("the force does not grow beyond a limit, and falls at once when the needle turns back from one that yields") {
  LocalModel model = pressed(1000, 0.5);
  model.forward = 0.3e-3;
  model.forward_limit = Limit::cutting;
  LocalResponse response(model, kCouplingSpring, kTwistSpring, kSticking);
  CHECK(felt(response, 10e-3) == doctest::Approx(-0.8));
  CHECK(felt(response, 20e-3) == doctest::Approx(-0.8));
  // One millimetre back: springs in series from where it turned.
  CHECK(felt(response, 19e-3) == doctest::Approx(-0.8 + 1e-3 / (1 / 1000.0 + 1 / kCouplingSpring)));
}

TEST_CASE("contact that ends pulls nothing, and comes back where it ended") {
  LocalModel model = pressed(1000, 0.5);
  model.backward = 0.5e-3;
  model.backward_limit = Limit::contact;
  LocalResponse response(model, kCouplingSpring, kTwistSpring, kSticking);
  const double there = felt(response, 1e-3);
  CHECK(std::abs(felt(response, -10e-3)) < 1e-12);
  CHECK(felt(response, 1e-3) == doctest::Approx(there));
}

TEST_CASE("behind a surface only the weight is felt, sideways too, and the needle goes where the device goes") {
  LocalModel model = pressed(1000, 0.5);
  model.stiffness(1, 1) = -300;
  model.backward = 0.5e-3;
  model.backward_limit = Limit::contact;
  model.in_air.force[2] = -0.01;
  LocalResponse response(model, kCouplingSpring, kTwistSpring, kSticking);
  CHECK(response({{{1e-3, 2e-3, 0}}, {}}).felt.force[1] < -0.1);
  const auto answer = response({{{-5e-3, 2e-3, 0}}, {}});
  CHECK(answer.felt.force[1] == 0);
  CHECK(answer.felt.force[2] == -0.01);
  CHECK(answer.proxy.position[1] == 2e-3);
}

TEST_CASE("a needle that slides resists on, and lets go when it turns back") {
  LocalModel model = pressed(0, 0.4);
  model.forward_limit = model.backward_limit = Limit::slip;
  LocalResponse response(model, kCouplingSpring, kTwistSpring, kSticking);
  CHECK(felt(response, 5e-3) == doctest::Approx(-0.4));
  CHECK(felt(response, 4.5e-3) == doctest::Approx(-0.4 + 0.5e-3 / (1 / kSticking + 1 / kCouplingSpring)));
  CHECK(std::abs(felt(response, 0)) < 1e-12);
}

TEST_CASE("a needle that slides and turns back sticks until it slides the other way") {
  LocalModel model = pressed(0, 0.4);
  model.forward_limit = model.backward_limit = Limit::slip;
  model.backward_change = 0.6;
  LocalResponse response(model, kCouplingSpring, kTwistSpring, kSticking);
  CHECK(felt(response, 5e-3) == doctest::Approx(-0.4));
  CHECK(felt(response, 4.5e-3) == doctest::Approx(-0.4 + 0.5e-3 / (1 / kSticking + 1 / kCouplingSpring)));
  CHECK(felt(response, 0) == doctest::Approx(0.2));
  CHECK(felt(response, -5e-3) == doctest::Approx(0.2));
}

TEST_CASE("a needle that nothing touches is felt with its weight alone") {
  LocalResponse response(pressed(0, 0.4), kCouplingSpring, kTwistSpring, kSticking);
  CHECK(felt(response, 5e-3) == doctest::Approx(-0.4));
  CHECK(felt(response, -5e-3) == doctest::Approx(-0.4));
}

TEST_CASE("a place that the needle was sent to meanwhile has yielded there") {
  LocalModel model = pressed(1000, 0.5);
  model.forward = 0;
  model.forward_limit = Limit::slip;
  LocalResponse response(model, kCouplingSpring, kTwistSpring, kSticking);
  response.pass({{{8e-3, 0, 0}}, {}});
  // 0.5 N at 8 mm: the device that drags with 0.5 N is 0.5/400 m ahead of it.
  CHECK(felt(response, 8e-3 + 0.5 / kCouplingSpring) == doctest::Approx(-0.5));
}

TEST_CASE("what only a tick's haste gives is not felt while the force grows") {
  LocalResponse response(pressed(1000, 0.1), kCouplingSpring, kTwistSpring, kSticking, 900);
  const double series = 100 * kCouplingSpring / (100 + kCouplingSpring);
  const double ahead = 0.1 / kCouplingSpring;  // m, of the device where the needle is at its place
  CHECK(felt(response, ahead + 1e-3) == doctest::Approx(-0.1 - series * 1e-3));
  const double back = 1e-4;
  CHECK(felt(response, ahead - back) == doctest::Approx(-0.1 + back / (1 / 1000.0 + 1 / kCouplingSpring)));
}

TEST_CASE("the answer does not depend on where the world's axes are") {
  LocalModel model;
  model.felt = {{{-0.5, 0.1, 0.2}}, {{0.01, -0.02, 0.03}}};
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j) model.stiffness(i, j) = i == j ? -(i < 3 ? 300 : 0.5) : -0.3;
  model.forward = 1e-3;
  const Pose device{{{4e-3, 1e-3, -2e-3}}, rotation({{0.02, -0.03, 0.05}})};
  LocalResponse here(model, kCouplingSpring, kTwistSpring, kSticking);

  const Quaternion turn = rotation({{0.7, -1.1, 0.4}});
  const auto turned = [&](const Pose& pose) { return Pose{turn * pose.position, normalized(turn * pose.orientation)}; };
  LocalModel there_model = model;
  there_model.base = turned(model.base);
  there_model.felt = {turn * model.felt.force, turn * model.felt.torque};
  for (int column = 0; column < 6; ++column) {
    Vector6 unit;  // of the turned world, seen from this one
    unit[column] = 1;
    const Wrench halves = wrench_of(unit);
    const Vector6 way = joined(turn.conjugate() * halves.force, turn.conjugate() * halves.torque);
    const Wrench answer = wrench_of(model.stiffness * way);
    const Vector6 back = joined(turn * answer.force, turn * answer.torque);
    for (int i = 0; i < 6; ++i) there_model.stiffness(i, column) = back[i];
  }
  LocalResponse there(there_model, kCouplingSpring, kTwistSpring, kSticking);
  // The device's orientation against the base's is the same.
  const Pose device_there{turn * device.position, normalized(turn * device.orientation)};
  const auto a = here(device), b = there(device_there);
  CHECK(norm(turn * a.felt.force - b.felt.force) < 1e-10);
  CHECK(norm(turn * a.felt.torque - b.felt.torque) < 1e-10);
  CHECK(norm(turn * a.proxy.position - b.proxy.position) < 1e-12);
}
