// SPDX-License-Identifier: GPL-3.0-or-later
// A needle clamped to a test bench: its body, and its equilibrium under dead loads.
#pragma once

#include <doctest/doctest.h>

#include "tests/models/motions.h"

namespace acus {

struct NeedleLoad {
  int beam;
  Vector12 force;  // on the beam's two nodes (N, N m), world
};

inline NeedleBody bench_body() {
  NeedleBody body;
  body.material.rayleigh_stiffness = 0;
  return body;
}

// A dead force or couple on the last node.
inline NeedleLoad tip_load(const NeedleModel& model, const Vector3& force, const Vector3& couple) {
  NeedleLoad load{model.beams - 1, Vector12::Zero()};
  load.force.segment<3>(6) = force;
  load.force.segment<3>(9) = couple;
  return load;
}

struct Equilibrium {
  NeedleState state;
  Vector6 reaction;
};

// Newton's method in load steps. The time step is so long that inertia plays no part.
inline Equilibrium find_equilibrium(const NeedleModel& model, const Pose& base, const NeedleLoad& load,
                                    int load_steps = 10) {
  NeedleMotion motion(model, 1e4, 1);
  Equilibrium result{make_needle_state(model, base), Vector6::Zero()};
  for (int step = 1; step <= load_steps; ++step) {
    const double lambda = static_cast<double>(step) / load_steps;
    motion.begin(result.state, base);
    double moved = 1;
    for (int iteration = 0; iteration < 60 && moved > 1e-13; ++iteration) {
      motion.linearize(result.state);
      motion.clear_rows();
      motion.add_row(load.beam, load.force);
      moved = motion.correct({&lambda, 1});
    }
    REQUIRE(moved < 1e-10);
    motion.commit(result.state);
    result.state.v.setZero();
  }
  result.reaction = motion.base_reaction();
  return result;
}

}  // namespace acus
