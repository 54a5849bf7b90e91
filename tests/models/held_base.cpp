// SPDX-License-Identifier: GPL-3.0-or-later
// Bases that a spring and a damper hold: closed forms, the limit of a stiff spring, what rows see, and that it is
// passive.
#include <doctest/doctest.h>

#include "server/engine/math/random.h"
#include "server/engine/math/rotation.h"
#include "server/engine/models/needle/held_base.h"
#include "tests/models/bench_needle.h"

namespace acus {
namespace {

const Vector3 kGravity(0, 0, -9.81);
const BaseHold kHold{400, 3, 2, 0.01};

NeedleModel held_needle(bool rigid, const BaseHold& hold, const Vector3& gravity = Vector3::Zero(), int beams = 10) {
  NeedleBody body = bench_body();
  body.beams = beams;
  return make_needle_model(body, gravity, rigid, hold);
}

void tick(NeedleMotion& motion, NeedleState& state, const Pose& commanded, const Pose& before) {
  motion.begin(state, commanded, before);
  for (double moved = 1; moved > 1e-12;) {
    motion.linearize(state);
    motion.clear_rows();
    moved = motion.correct({});
  }
}

double weight(const NeedleModel& model) { return model.mass.sum() * 9.81; }

}  // namespace

TEST_CASE("a needle sags on its holder's springs by its weight over their stiffness") {
  for (const bool rigid : {true, false}) {
    const NeedleModel model = held_needle(rigid, kHold, kGravity);
    NeedleState state = make_needle_state(model, {});
    NeedleMotion motion(model, 1e4, 0);
    tick(motion, state, {}, {});
    motion.commit(state);
    CHECK(state.x(2, 0) == doctest::Approx(-weight(model) / kHold.stiffness).epsilon(1e-6));
    const Vector3 turn = rotation_log(state.q[0]);
    const double arm =
        (state.x.row(0) * model.mass - model.mass.sum() * state.x.col(0).row(0)).value() / model.mass.sum();
    CHECK(turn.y() == doctest::Approx(weight(model) * arm / kHold.angular_stiffness).epsilon(1e-6));
    CHECK(motion.base_reaction()[2] == doctest::Approx(weight(model)).epsilon(1e-9));
  }
}

TEST_CASE("a rigid needle on its spring swings as backward Euler lets a mass on a spring swing") {
  BaseHold hold = kHold;
  hold.damping = 0.05;
  hold.angular_stiffness = 1e9;  // it does not turn
  const NeedleModel model = held_needle(true, hold);
  const double m = model.mass.sum(), k = hold.stiffness, c = hold.damping, h = 1e-4;
  NeedleState state = make_needle_state(model, {{0, 1e-3, 0}, Quaternion::Identity()});
  NeedleMotion motion(model, h, 0);
  double y = 1e-3, v = 0;
  for (int i = 0; i < 2000; ++i) {
    tick(motion, state, {}, {});
    motion.commit(state);
    const double next = (m / (h * h) * y + m / h * v + c / h * y) / (m / (h * h) + c / h + k);
    v = (next - y) / h;
    y = next;
    REQUIRE(state.x(1, 0) == doctest::Approx(y).epsilon(1e-6).scale(1e-3));
  }
}

TEST_CASE("on springs that are stiff enough a base is where it is told, and its reaction that of such a base") {
  for (const bool rigid : {true, false}) {
    const BaseHold stiff{1e9, 0, 1e8, 0};
    const NeedleModel held = held_needle(rigid, stiff, kGravity);
    NeedleModel commanded = held;
    commanded.hold.reset();
    NeedleState one = make_needle_state(held, {}), other = one;
    NeedleMotion motion(held, 1e-3, 0), exact(commanded, 1e-3, 0);
    Random random(5);
    Pose base, before;
    for (int i = 0; i < 50; ++i) {
      before = base;
      base.position += random.vector(1e-4);
      base.orientation = (rotation_exp(random.vector(0.01)) * base.orientation).normalized();
      tick(motion, one, base, before);
      tick(exact, other, base, before);
      CHECK((motion.base_reaction() - exact.base_reaction()).norm() < 1e-4 * exact.base_reaction().norm());
      motion.commit(one);
      exact.commit(other);
      CHECK((one.x - other.x).cwiseAbs().maxCoeff() < 1e-8);
    }
  }
}

TEST_CASE("rows see a held base give way: compliances and free displacements are those of solutions") {
  for (const bool rigid : {true, false}) {
    const NeedleModel model = held_needle(rigid, kHold, kGravity);
    NeedleState state = make_needle_state(model, {{0.1, 0, 0.2}, rotation_exp({0.4, -0.3, 1})});
    Random random(7);
    const int rows = 6;
    std::vector<BeamRow> all;
    for (const int beam : {0, 3, 0, 9, 5, 9}) {
      Vector12 force;
      for (int i = 0; i < 12; ++i) force[i] = i % 6 < 3 ? random.uniform(-1, 1) : random.uniform(-0.01, 0.01);
      all.push_back({beam, force});
    }
    NeedleMotion motion(model, 1e-3, rows);
    motion.begin(state, {{0.101, 0, 0.2}, rotation_exp({0.41, -0.3, 1})}, {state.x.col(0), state.q[0]});
    motion.linearize(state);
    for (const BeamRow& row : all) motion.add_row(row.beam, row.force);
    MatrixX W = MatrixX::Zero(rows, rows);
    std::vector<int> places{4, 0, 5, 1, 3, 2};
    motion.add_compliances(places, W);

    // By what the nodes do in the step, of a motion that starts anew for each.
    const auto displacements = [&](const std::vector<double>& lambda) {
      NeedleMotion again(model, 1e-3, rows);
      again.begin(state, {{0.101, 0, 0.2}, rotation_exp({0.41, -0.3, 1})}, {state.x.col(0), state.q[0]});
      again.linearize(state);
      for (const BeamRow& row : all) again.add_row(row.beam, row.force);
      const NeedleShape start = again.shape();
      again.solve(lambda);
      again.move(1e-6);  // so little that turns are rotation vectors
      const NeedleShape& end = again.shape();
      VectorX moved(rows);
      for (int r = 0; r < rows; ++r) {
        const int b = all[r].beam;
        const auto turn = [&](int node) {
          return rotation_log(Quaternion(Matrix3(end.frames[node] * start.frames[node].transpose())));
        };
        Vector12 step;
        step << end.x.col(b) - start.x.col(b), turn(b), end.x.col(b + 1) - start.x.col(b + 1), turn(b + 1);
        moved[r] = all[r].force.dot(step) / 1e-6;
      }
      return moved;
    };
    const std::vector<double> none(rows, 0.0);
    const VectorX free = displacements(none);
    for (int r = 0; r < rows; ++r)
      CHECK(motion.free_displacement(r) == doctest::Approx(free[r]).epsilon(1e-5).scale(1e-4));
    for (int s = 0; s < rows; ++s) {
      std::vector<double> unit = none;
      unit[s] = 1;
      const VectorX seen = displacements(unit) - free;
      for (int r = 0; r < rows; ++r) {
        const double entry = W(std::max(places[r], places[s]), std::min(places[r], places[s]));
        CHECK(entry == doctest::Approx(seen[r]).epsilon(1e-4).scale(W.diagonal().maxCoeff() * 1e-2));
      }
    }
  }
}

TEST_CASE("against moves of its holder a needle is as stiff as holder and needle one behind the other") {
  const NeedleModel model = held_needle(true, {500, 0, 1e9, 0});
  const double h = 1e-3, of_mass = model.mass.sum() / (h * h);
  NeedleState state = make_needle_state(model, {});
  NeedleMotion motion(model, h, 0);
  motion.begin(state, {});
  motion.linearize(state);
  MatrixX follow(motion.free_unknowns(), 6);
  motion.follow_base(follow);
  const Matrix6 tangent = motion.base_tangent(follow);
  CHECK(tangent(1, 1) == doctest::Approx(1 / (1 / 500.0 + 1 / of_mass)).epsilon(1e-6));
  CHECK((tangent - tangent.transpose()).norm() < 1e-9 * tangent.norm());
}

TEST_CASE("a holder that goes to and fro puts in all that needle and spring have") {
  for (const bool rigid : {true, false}) {
    const NeedleModel model = held_needle(rigid, kHold);
    NeedleState state = make_needle_state(model, {});
    NeedleMotion motion(model, 1e-3, 0);
    Random random(11);
    Pose commanded, before;
    double work = 0;
    for (int i = 0; i < 500; ++i) {
      before = commanded;
      commanded.position += random.vector(2e-4);
      commanded.orientation = (rotation_exp(random.vector(0.005)) * commanded.orientation).normalized();
      tick(motion, state, commanded, before);
      const Vector6 wrench = motion.base_reaction();
      work += wrench.head<3>().dot(commanded.position - before.position) +
              wrench.tail<3>().dot(rotation_log(commanded.orientation * before.orientation.conjugate()));
      motion.commit(state);
      const Vector3 apart = commanded.position - state.x.col(0);
      const Vector3 turned = rotation_log(commanded.orientation * state.q[0].conjugate());
      NeedleShape shape;
      put_shape(state, shape);
      const double stored = kinetic_energy(model, state) + elastic_energy(model, shape) +
                            kHold.stiffness / 2 * apart.squaredNorm() +
                            kHold.angular_stiffness / 2 * turned.squaredNorm();
      CHECK(stored <= work * (1 + 1e-3) + 1e-12);
    }
  }
}

TEST_CASE("a needle that is held keeps to itself where its holder rests, however long a tick is") {
  const NeedleModel model = held_needle(false, kHold);
  for (const double h : {1e-5, 1e-3, 1.0}) {
    NeedleState state = make_needle_state(model, {});
    const NeedleState start = state;
    NeedleMotion motion(model, h, 0);
    for (int i = 0; i < 10; ++i) {
      tick(motion, state, {}, {});
      motion.commit(state);
    }
    CHECK((state.x - start.x).cwiseAbs().maxCoeff() < 1e-15);
    CHECK(motion.base_reaction().norm() < 1e-9);
  }
}

}  // namespace acus
