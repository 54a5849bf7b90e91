// SPDX-License-Identifier: GPL-3.0-or-later
// Outcomes of the scene `steering`: which way bevelled and symmetric tips go. Paths are compared at rest, so that the
// tissue's own displacement does not count as steering.
#include <doctest/doctest.h>

#include <numbers>

#include "server/engine/math/rotation.h"
#include "tests/validation/scene_run.h"

namespace acus::test {
namespace {

void leave_out_spin(client::Trajectory& trajectory) {
  for (client::Sample& sample : trajectory.motions[0].samples) sample.pose.spin = 0;
}

// Turns needle, guide and motion about the needle's axis, on which all of them lie.
void turn_about_axis(Scene& scene, client::Trajectory& trajectory, double angle) {
  const Quaternion turn = rotation_exp({angle, 0, 0});  // base frame
  scene.needles[0].base.orientation = scene.needles[0].base.orientation * turn;
  scene.guides[0].pose.orientation = scene.guides[0].pose.orientation * turn;
  for (client::Sample& sample : trajectory.motions[0].samples) {
    auto& q = sample.pose.orientation;
    const Quaternion turned = Quaternion(q[0], q[1], q[2], q[3]) * turn;
    q = {turned.w(), turned.x(), turned.y(), turned.z()};
  }
}

// Curvature (1/m) of a path towards `side` between two depths (m below the top face, at rest).
double path_curvature(const Matrix3X& path, const Vector3& side, double from, double to) {
  constexpr double kTop = 0.06;
  std::vector<double> depth, offset;
  for (int i = 0; i < path.cols(); ++i) {
    depth.push_back(kTop - path(2, i));
    offset.push_back(side.dot(path.col(i)));
  }
  return curvature(depth, offset, from, to, 5);
}

Matrix3X steered_path(const SceneRun::Change& change) {
  SceneRun run("steering", change);
  run.run();
  check_sound(run);
  return path_at_rest(run.simulation(), 0);
}

// Of the depth that the path has when the base is spun, and of its end (m).
constexpr double kSpunAt = 0.045, kEnd = 0.09;

}  // namespace

TEST_CASE("steering: spun half way, the path is an S") {
  const Matrix3X path = steered_path({});
  const double first = path_curvature(path, Vector3::UnitY(), 0.004, kSpunAt);
  const double second = path_curvature(path, Vector3::UnitY(), kSpunAt + 0.004, kEnd + 0.01);
  MESSAGE("curvature " << first << " then " << second << " 1/m");
  CHECK(first > 4);
  CHECK(second < -4);
}

TEST_CASE("steering: without the spin the path is a one-sided arc") {
  const Matrix3X path = steered_path([](Scene&, client::Trajectory& trajectory) { leave_out_spin(trajectory); });
  const double first = path_curvature(path, Vector3::UnitY(), 0.004, kSpunAt);
  const double second = path_curvature(path, Vector3::UnitY(), kSpunAt + 0.004, kEnd);
  MESSAGE("curvature " << first << " then " << second << " 1/m");
  CHECK(first > 4);
  CHECK(second > 4);
  for (int i = 1; i < path.cols(); ++i) CHECK(path(1, i) > path(1, i - 1));
}

TEST_CASE("steering: a mirrored bevel mirrors the path" * doctest::test_suite("full")) {
  // The mesh is its own image under an exchange of x and y, so bevels along (1, -1, 0) and (-1, 1, 0) are mirrored.
  const auto bevelled = [](double side) {
    return [side](Scene& scene, client::Trajectory& trajectory) {
      // The base's +y is the world's +y and its +z the world's +x.
      turn_about_axis(scene, trajectory, 0.75 * std::numbers::pi);
      scene.needles[0].cutting_direction.y() *= side;
      for (client::Sample& sample : trajectory.motions[0].samples) *sample.pose.spin *= side;
    };
  };
  const Matrix3X path = steered_path(bevelled(1)), other = steered_path(bevelled(-1));
  REQUIRE(path.cols() == other.cols());
  const Vector3 side = Vector3(1, -1, 0).normalized();
  double offset = 0, difference = 0;
  for (int i = 0; i < path.cols(); ++i) {
    offset = std::max(offset, std::abs(side.dot(path.col(i))));
    difference = std::max(difference, (Vector3(path(1, i), path(0, i), path(2, i)) - other.col(i)).norm());
  }
  MESSAGE("offset " << 1e3 * offset << " mm, the mirrored paths differ by " << 1e3 * difference << " mm");
  CHECK(offset > 0.01);
  CHECK(difference < 8e-3 * offset);  // the tip stands on an edge of the mesh: rounding picks its element
}

TEST_CASE("steering: a symmetric tip stays on its axis") {
  SceneRun run("steering", [](Scene& scene, client::Trajectory& trajectory) {
    scene.needles[0].cutting_direction = Vector3::UnitX();
    leave_out_spin(trajectory);
  });
  run.run();
  check_sound(run);
  double world = 0;
  for (const TickReport& tick : run.ticks()) world = std::max(world, tick.needles[0].tip_position.head<2>().norm());
  const double rest = path_at_rest(run.simulation(), 0).topRows<2>().colwise().norm().maxCoeff();
  MESSAGE("off the axis by " << 1e3 * world << " mm in the world, " << 1e3 * rest << " mm at rest");
  CHECK(world < 0.05e-3);
  CHECK(rest < 0.05e-3);
}

TEST_CASE("steering: nothing stirs while the base rests") {
  SceneRun run("steering");
  run.run();
  double largest = 0;
  for (std::size_t i = run.ticks().size() - 100; i < run.ticks().size(); ++i)
    largest = std::max(largest, std::abs(run.resistance(i) - run.resistance(i - 1)));
  MESSAGE("largest step of the base's force in the last 0.2 s: " << largest << " N");
  CHECK(largest < 2e-9);
}

}  // namespace acus::test
