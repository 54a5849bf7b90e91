// SPDX-License-Identifier: GPL-3.0-or-later
// The base's stiffness against differences of ticks that were made twice, with the base elsewhere at their end.
#include <doctest/doctest.h>

#include <functional>

#include "server/engine/math/rotation.h"
#include "server/engine/tick/simulation.h"
#include "tests/support/small_block.h"

namespace acus {
namespace {

constexpr double kShift = 1e-8, kTurn = 1e-8;  // m, rad: far below what any law's piece lasts for
constexpr double kMostOff = 0.02;

// The base follows what it is told at once.
Scene direct_scene() {
  Scene scene = test::small_block();
  scene.needles[0].smoothing = 0;
  scene.needles[0].max_speed = scene.needles[0].max_angular_speed = scene.needles[0].max_spin_speed = 1e6;
  return scene;
}

Vector6 wrench(const Simulation& simulation) {
  Vector6 w;
  w << simulation.report().needles[0].base_force, simulation.report().needles[0].base_torque;
  return w;
}

Pose moved(const Pose& pose, const Vector6& by) {
  return {pose.position + by.head<3>(), (rotation_exp(by.tail<3>()) * pose.orientation).normalized()};
}

void step_to(Simulation& simulation, const Pose& pose, double spin) {
  REQUIRE(simulation.command(0, {.seq = 1, .pose = pose, .spin = spin}));
  simulation.step();
}

// d(wrench)/d(pose) of the tick from `before` to a pose, by differences.
Matrix6 by_differences(const Scene& scene, const State& before, const Pose& pose, double spin) {
  Simulation branch(scene);
  Matrix6 stiffness;
  for (int axis = 0; axis < 6; ++axis) {
    const double size = axis < 3 ? kShift : kTurn;
    const auto at = [&](double sign) {
      branch.restore(before);
      step_to(branch, moved(pose, sign * size * Vector6::Unit(axis)), spin);
      return wrench(branch);
    };
    stiffness.col(axis) = (at(1) - at(-1)) / (2 * size);
  }
  return stiffness;
}

// What the model leaves out (base_stiffness.h): lengths of needle beside path vertices change as the needle moves
// along, and with them what they bear. N/m.
double left_out(const NeedleReport& needle, const Needle& parameters) {
  if (needle.phase != protocol::Phase::inside) return 0;
  return (needle.friction_force.norm() + needle.lateral_force.norm()) / parameters.constraint_spacing;
}

// The largest error of an entry, of what the entries on the diagonal in its row and column are; a needle turns easily
// about itself, where these are next to nothing. `allowed` (N/m) is taken off, turns have the needle's length as lever.
double largest_error(const Matrix6& found, const Matrix6& expected, double allowed, double lever) {
  const auto scale = [&](int i) {
    const double largest = expected.diagonal().segment<3>(i < 3 ? 0 : 3).cwiseAbs().maxCoeff();
    return std::sqrt(std::max(std::abs(expected(i, i)), 0.01 * largest));
  };
  const auto arm = [&](int i) { return i < 3 ? 1 : lever; };
  double worst = 0;
  for (int j = 0; j < 6; ++j)
    for (int i = 0; i < 6; ++i) {
      const double error = std::abs(found(i, j) - expected(i, j)) - allowed * arm(i) * arm(j);
      worst = std::max(worst, error / (scale(i) * scale(j)));
    }
  return worst;
}

struct Motion {
  Vector3 velocity = Vector3::Zero();  // m/s, in the base's frame
  Vector3 turning = Vector3::Zero();   // rad/s, likewise
  double spinning = 0;                 // rad/s
  double seconds = 0;
};

struct Seen {
  int checked = 0, contact = 0, inside = 0, slipping = 0, touching = 0;
};

// Moves a needle, and compares every `every` ticks, from one on.
Seen compare_along(const Scene& scene, const std::vector<Motion>& motions, int every, int from = 0) {
  Simulation simulation(scene);
  const double h = 1 / scene.rate;
  Pose pose = scene.needles[0].base;
  double spin = 0;
  Seen seen;
  int tick = 0;
  for (const Motion& motion : motions)
    for (int i = 0; i < motion.seconds / h; ++i) {
      pose.position += pose.orientation * (h * motion.velocity);
      pose.orientation = (pose.orientation * rotation_exp(h * motion.turning)).normalized();
      spin += h * motion.spinning;
      const bool look = ++tick % every == 0 && tick >= from;
      const State before = look ? simulation.state() : State{};
      step_to(simulation, pose, spin);
      if (!look) continue;
      const NeedleReport& needle = simulation.report().needles[0];
      const BaseStiffness found = simulation.base_stiffnesses()[0];
      const Matrix6 expected = by_differences(scene, before, pose, spin);
      CAPTURE(simulation.report().time);
      CAPTURE(needle.inserted_depth);
      CAPTURE(found.stiffness);
      CAPTURE(expected);
      const double allowed = left_out(needle, scene.needles[0]);
      CAPTURE(allowed);
      CHECK(largest_error(found.stiffness, expected, allowed, scene.needles[0].length) < kMostOff);
      CHECK(found.forward >= 0);
      CHECK(found.backward >= 0);
      ++seen.checked;
      seen.inside += needle.phase == protocol::Phase::inside;
      seen.contact += needle.phase == protocol::Phase::contact;
      seen.touching += needle.needle_force.norm() > 0;
      seen.slipping += found.forward_limit == ModelLimit::slip || found.backward_limit == ModelLimit::slip;
    }
  return seen;
}

const std::vector<Motion> kInAndOut{{.velocity = {0.02, 0, 0}, .seconds = 1},
                                    {.velocity = {0.02, 0.004, 0}, .turning = {0, 0, 0.1}, .seconds = 0.5},
                                    {.velocity = {0, 0, 0}, .seconds = 0.2},
                                    {.velocity = {-0.02, 0, 0.002}, .spinning = 1, .seconds = 1}};

TEST_CASE("the base's stiffness is that of ticks made anew, free, in contact, cutting, sliding and held") {
  const Seen seen = compare_along(direct_scene(), kInAndOut, 17);
  CHECK(seen.contact > 3);
  CHECK(seen.inside > 40);
  CHECK(seen.slipping > 20);
}

TEST_CASE("a rigid needle's stiffness at the base is that of ticks made anew") {
  Scene scene = direct_scene();
  scene.needles[0].rung = NeedleRung::rigid;
  CHECK(compare_along(scene, kInAndOut, 29).inside > 20);
}

TEST_CASE("with a base on springs the stiffness is that against moves of what holds it") {
  for (const NeedleRung rung : {NeedleRung::flexible, NeedleRung::rigid}) {
    Scene scene = direct_scene();
    scene.needles[0].rung = rung;
    scene.needles[0].hold = BaseHold{.stiffness = 300, .damping = 1, .angular_stiffness = 3, .angular_damping = 0.01};
    CHECK(compare_along(scene, kInAndOut, 29).inside > 20);
  }
}

TEST_CASE("with a hub on the skin that is pressed, tilted and moved along it") {
  for (const NeedleRung rung : {NeedleRung::flexible, NeedleRung::rigid}) {
    Scene scene = direct_scene();
    Needle& needle = scene.needles[0];
    needle.rung = rung;
    needle.base.position.z() -= needle.length - 0.02;
    needle.length = 0.02;
    needle.hub_diameter = 8e-3;
    const std::vector<Motion> motions{{.velocity = {0.02, 0, 0}, .seconds = 1.1},
                                      {.velocity = {0, 0.003, 0}, .turning = {0, 0, 0.2}, .seconds = 0.3},
                                      {.velocity = {-0.02, 0, 0}, .seconds = 0.3}};
    constexpr int kNearSkin = 450;  // the hub, at 20 mm/s
    CHECK(compare_along(scene, motions, 17, kNearSkin).inside > 20);
  }
}

TEST_CASE("with torsional and viscous friction, and a bevel that is turned") {
  Scene scene = direct_scene();
  scene.needles[0].torsional_friction = 1;
  scene.needles[0].cutting_direction = {1, 0.1, 0};
  scene.tissue.regions[0].interaction.friction_viscous = 20;
  CHECK(compare_along(scene, kInAndOut, 29).inside > 20);
}

TEST_CASE("with friction that thins and is less on the way back" * doctest::test_suite("gate")) {
  for (const double share : {0.0, 1.0}) {
    CAPTURE(share);
    Scene scene = direct_scene();
    Interaction& law = scene.tissue.regions[0].interaction;
    law.friction_viscous = 2000;
    law.friction_thinning_speed = 2e-3;
    law.friction_exponent = 0.3;
    law.friction_back = 0.5;
    scene.needles[0].torsional_friction = share;
    CHECK(compare_along(scene, kInAndOut, 29).inside > 20);
  }
}

TEST_CASE("friction that holds lets go where the model says, pushed in and drawn back, whose friction is less" *
          doctest::test_suite("gate")) {
  Scene scene = direct_scene();
  scene.needles[0].rung = NeedleRung::rigid;
  Interaction& law = scene.tissue.regions[0].interaction;
  law.friction_back = 0.3;
  law.friction_static = law.friction_dynamic;
  law.cutting_force = 0;
  Simulation simulation(scene), branch(scene);
  const double h = 1 / scene.rate;
  Pose pose = scene.needles[0].base;
  const Vector3 ahead = pose.orientation * Vector3::UnitX();
  for (int tick = 0; tick < 1 / h; ++tick)
    step_to(simulation, pose = {pose.position + 0.02 * h * ahead, pose.orientation}, 0);
  for (int tick = 0; tick < 0.2 / h; ++tick) step_to(simulation, pose, 0);
  // Back by part of what it stands, so that it is stuck with the force of a push.
  for (int tick = 0; tick < 20; ++tick) step_to(simulation, pose = {pose.position - 2e-7 * ahead, pose.orientation}, 0);
  const State before = simulation.state();
  step_to(simulation, pose, 0);
  const BaseStiffness model = simulation.base_stiffnesses()[0];
  REQUIRE(model.backward_limit == ModelLimit::slip);
  const auto back = [&](double by) {
    branch.restore(before);
    step_to(branch, {pose.position - by * ahead, pose.orientation}, 0);
    int sliding = 0;
    for (const VertexState& vertex : branch.state().insertions[0].vertices)
      sliding += vertex.contact.along > 0 && vertex.contact.sliding;
    return sliding;
  };
  MESSAGE("lets go ", 1e6 * model.backward, " um back");
  CHECK(back(0.97 * model.backward) == 0);
  CHECK(back(1.03 * model.backward) > 0);
}

TEST_CASE("with friction in one cone, spun while it goes in and while it rests") {
  Scene scene = direct_scene();
  scene.needles[0].torsional_friction = 1;
  const std::vector<Motion> motions{{.velocity = {0.02, 0, 0}, .seconds = 1},
                                    {.velocity = {0.02, 0, 0}, .spinning = 18, .seconds = 0.5},
                                    {.spinning = 18, .seconds = 0.5}};
  CHECK(compare_along(scene, motions, 29).inside > 20);
}

TEST_CASE("a tip that slides along the surface follows with its friction the force that it presses with") {
  Scene scene = direct_scene();
  scene.tissue.regions[0].interaction.puncture_force = kInfinity;
  scene.tissue.regions[0].interaction.friction_contact = 0.3;
  const std::vector<Motion> motions{{.velocity = {0.01, 0, 0}, .seconds = 0.3},
                                    {.velocity = {0, 0.02, 0.01}, .seconds = 0.6}};
  CHECK(compare_along(scene, motions, 11).contact > 20);
}

TEST_CASE("where it presses on another needle, and slides on it, the stiffness has both needles in it") {
  Scene scene = direct_scene();
  scene.tissue.rung = TissueRung::none;
  scene.needles.push_back(scene.needles[0]);
  scene.needles[1].name = "other";
  const Pose& base = scene.needles[0].base;
  const double d = scene.needles[0].outer_diameter;
  scene.needles[1].base = {base * Vector3(0.6 * scene.needles[0].length, -0.05, d + 1e-4),
                           base.orientation * rotation_exp({0, 0, 1.5})};
  const std::vector<Motion> motions{{.velocity = {0, 0, 0.02}, .seconds = 0.1},
                                    {.velocity = {0.02, 0, 0.01}, .seconds = 0.2},
                                    {.velocity = {0, 0, 0}, .seconds = 0.2}};
  const Seen seen = compare_along(scene, motions, 7);
  CHECK(seen.touching > 30);
}

TEST_CASE("up to its limits the linear model gives the force that a tick with the base there has") {
  const Scene scene = direct_scene();
  Simulation simulation(scene), branch(scene);
  const double h = 1 / scene.rate;
  Pose pose = scene.needles[0].base;
  int compared = 0, punctures = 0;
  for (int tick = 1; tick < 0.8 / h; ++tick) {
    pose.position += pose.orientation * Vector3(0.02 * h, 0, 0);
    const State before = simulation.state();
    step_to(simulation, pose, 0);
    const BaseStiffness model = simulation.base_stiffnesses()[0];
    punctures += model.forward_limit == ModelLimit::puncture;
    if (tick % 7 != 0 || model.forward == kFarthest || simulation.report().flags != 0) continue;
    const Vector3 ahead = 0.9 * model.forward * (pose.orientation * Vector3::UnitX());
    branch.restore(before);
    step_to(branch, {pose.position + ahead, pose.orientation}, 0);
    const Vector3 predicted = wrench(simulation).head<3>() + model.stiffness.topLeftCorner<3, 3>() * ahead;
    const double change = (wrench(branch).head<3>() - wrench(simulation).head<3>()).norm();
    CAPTURE(tick);
    CAPTURE(model.forward);
    CHECK((predicted - wrench(branch).head<3>()).norm() < std::max(0.1 * change, 1e-4));
    ++compared;
  }
  CHECK(compared > 20);
  CHECK(punctures > 10);
}

Vector3 weight(const Scene& scene) {
  const Simulation simulation(scene);
  return simulation.model().needles[0].mass.sum() * scene.gravity;
}

TEST_CASE("what lasts of a needle that is swung through the air is its weight" * doctest::test_suite("gate")) {
  Scene scene = direct_scene();
  scene.gravity = {0, 0, -9.81};
  scene.needles[0].base = {{0.2, 0, 0.3}, Quaternion::Identity()};  // lies, beside the block
  for (const NeedleRung rung : {NeedleRung::rigid, NeedleRung::flexible}) {
    scene.needles[0].rung = rung;
    Simulation simulation(scene);
    Pose pose = scene.needles[0].base;
    double most = 0;
    for (int tick = 0; tick < 100; ++tick) {
      pose.position.y() += 1e-4 * std::sin(0.3 * tick);
      step_to(simulation, pose, 0);
      const Vector6 lasting = simulation.base_stiffnesses()[0].lasting;
      const Vector3 torque = (0.5 * scene.needles[0].length * Vector3::UnitX()).cross(weight(scene));
      CHECK((lasting.head<3>() - weight(scene)).norm() < 1e-12);
      CHECK(lasting[4] == doctest::Approx(torque.y()).epsilon(0.01));  // but for what it sags and bends
      most = std::max(most, (wrench(simulation) - lasting).head<3>().norm());
    }
    CHECK(most > 0.002);  // 0.0046
  }
}

TEST_CASE("what lasts is the sum of the laws' forces, and all there is of a needle that was held for long" *
          doctest::test_suite("gate")) {
  const Scene scene = direct_scene();
  Simulation simulation(scene);
  Pose pose = scene.needles[0].base;
  const auto lasting = [&] { return simulation.base_stiffnesses()[0].lasting; };
  for (int tick = 0; tick < 500; ++tick) {
    pose.position += pose.orientation * Vector3(4e-5, 0, 0);
    step_to(simulation, pose, 0);
    const NeedleReport& n = simulation.report().needles[0];
    const Vector3 laws = n.cutting_force + n.friction_force + n.lateral_force + n.guide_force + weight(scene);
    REQUIRE((lasting().head<3>() - laws).norm() < 1e-9);
  }
  REQUIRE(simulation.report().needles[0].phase == protocol::Phase::inside);
  for (int tick = 0; tick < 1500; ++tick) step_to(simulation, pose, 0);
  CHECK(wrench(simulation).head<3>().norm() > 0.1);
  CHECK((wrench(simulation) - lasting()).head<3>().norm() < 1e-5);
  CHECK((wrench(simulation) - lasting()).tail<3>().norm() < 1e-6);
}

TEST_CASE("the yields are what a needle bears that is pushed and pulled on") {
  Scene scene = direct_scene();
  Interaction& laws = scene.tissue.regions[0].interaction;
  laws.friction_static = laws.friction_dynamic;
  Simulation simulation(scene);
  Pose pose = scene.needles[0].base;
  const auto go = [&](double speed, double seconds) {
    for (double t = 0; t < seconds; t += 1 / scene.rate) {
      pose.position += pose.orientation * Vector3(speed / scene.rate, 0, 0);
      step_to(simulation, pose, 0);
    }
    return -simulation.base_stiffnesses()[0].lasting.head<3>().dot(pose.orientation * Vector3::UnitX());
  };
  CHECK(simulation.base_stiffnesses()[0].forward_yield == 0);
  const double inward = go(0.02, 2);
  CHECK(inward == doctest::Approx(simulation.base_stiffnesses()[0].forward_yield).epsilon(0.02));
  const double outward = go(-0.02, 0.5);
  CHECK(-outward == doctest::Approx(simulation.base_stiffnesses()[0].backward_yield).epsilon(0.02));
}

TEST_CASE("before the first tick there is no stiffness, and none of it stays after a reset") {
  Simulation simulation(direct_scene());
  CHECK(simulation.base_stiffnesses()[0].stiffness.isZero());
  simulation.step();
  CHECK(!simulation.base_stiffnesses()[0].stiffness.isZero());
  simulation.reset();
  CHECK(simulation.base_stiffnesses()[0].stiffness.isZero());
}

}  // namespace
}  // namespace acus
