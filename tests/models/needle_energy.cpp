// SPDX-License-Identifier: GPL-3.0-or-later
// What a tick says of a needle's energy and strain.
#include <doctest/doctest.h>

#include "server/engine/math/random.h"
#include "server/engine/math/rotation.h"
#include "tests/models/bench_needle.h"

namespace acus {
namespace {

double stored(const NeedleModel& model, const NeedleState& state) {
  NeedleShape shape;
  put_shape(state, shape);
  return kinetic_energy(model, state) + elastic_energy(model, shape);
}

TEST_CASE("what a tick stores and gains is what its states and the work of base, loads and weight say, never more") {
  NeedleBody body;
  body.beams = 20;
  body.material.rayleigh_mass = 3;
  const NeedleModel model = make_needle_model(body, {0, 0, -9.81});
  NeedleState state = make_needle_state(model, {});
  NeedleMotion motion(model, 1e-3, 1);
  Random random(2);
  Pose base;
  for (int i = 0; i < 200; ++i) {
    CAPTURE(i);
    base = Pose{base.position + random.vector(1e-4), rotation_exp(random.vector(1e-3)) * base.orientation};
    const double lambda = random.uniform(-1, 1);
    const NeedleLoad load = tip_load(model, random.direction(), Vector3::Zero());
    motion.begin(state, base);
    for (int iteration = 0; iteration < 8; ++iteration) {
      motion.linearize(state);
      motion.clear_rows();
      motion.add_row(load.beam, load.force);
      motion.correct({&lambda, 1});
    }
    const NeedleEnergyChange change = motion.energy_change(state);
    NeedleState after = state;
    motion.commit(after);

    const Vector6 reaction = motion.base_reaction();
    double work = reaction.head<3>().dot(after.x.col(0) - state.x.col(0)) +
                  reaction.tail<3>().dot(rotation_log(after.q[0] * state.q[0].conjugate()));
    work += lambda * load.force.segment<3>(6).dot(after.x.rightCols<1>() - state.x.rightCols<1>());
    work -= potential_energy(model, after) - potential_energy(model, state);
    CHECK(change.stored == doctest::Approx(stored(model, after)).epsilon(1e-9));
    CHECK(change.gained == doctest::Approx(stored(model, after) - stored(model, state) - work).epsilon(1e-6).scale(1e-6));
    CHECK(change.gained < 1e-9 * change.stored);
    state = after;
  }
}

TEST_CASE("a needle that is given energy by its linearisation is told of") {
  const NeedleModel model = make_needle_model(bench_body(), Vector3::Zero());
  NeedleState state = make_needle_state(model, {});
  NeedleMotion motion(model, 1e-3, 1);
  motion.begin(state, {});
  motion.linearize(state);
  motion.clear_rows();
  // One step sideways by a tenth of the length: straight along the tangent, so that every beam is stretched.
  const NeedleLoad load = tip_load(model, {0, 1, 0}, Vector3::Zero());
  motion.add_row(load.beam, load.force);
  MatrixX W = MatrixX::Zero(1, 1);
  const int place = 0;
  motion.add_compliances({&place, 1}, W);
  const double lambda = 0.1 * model.length / W(0, 0);
  motion.correct({&lambda, 1});
  const NeedleEnergyChange change = motion.energy_change(state);
  CHECK(change.gained > 0.1 * change.stored);
}

TEST_CASE("the largest strain is that of a rod that is pulled, and of an arc that is bent") {
  const NeedleModel model = make_needle_model(bench_body(), Vector3::Zero());
  const auto strain_under = [&](const Vector3& force, const Vector3& couple) {
    const Equilibrium found = find_equilibrium(model, {}, tip_load(model, force, couple));
    NeedleMotion motion(model, 1e-3, 1);
    motion.begin(found.state, {});
    return motion.largest_strain();
  };
  CHECK(strain_under({1000, 0, 0}, Vector3::Zero()) == doctest::Approx(1000 / model.stiffness.axial).epsilon(1e-6));
  const double curvature = 2 / model.length;
  CHECK(strain_under(Vector3::Zero(), {0, 0, model.stiffness.bending * curvature}) ==
        doctest::Approx(curvature * model.diameter / 2).epsilon(1e-3));
}

}  // namespace
}  // namespace acus
