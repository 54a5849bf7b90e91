// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/golden/trace_hash.h"

#include <xxhash.h>

#include "server/simulation/state_bytes.h"

namespace acus::test {

namespace {

// Numbers one after the other: structs as a whole would bring padding along.
template <class Number>
void add_number(XXH3_state_t* state, Number number) {
  static_assert(std::is_arithmetic_v<Number> || std::is_enum_v<Number>);
  XXH3_64bits_update(state, &number, sizeof number);
}

template <class Derived>
void add_matrix(XXH3_state_t* state, const Eigen::MatrixBase<Derived>& matrix) {
  for (Eigen::Index j = 0; j < matrix.cols(); ++j)
    for (Eigen::Index i = 0; i < matrix.rows(); ++i) add_number(state, matrix(i, j));
}

void add_needle(XXH3_state_t* state, const NeedleReport& n) {
  add_number(state, n.command_seq);
  add_number(state, n.command_tick);
  add_number(state, n.phase);
  add_number(state, n.inserted_depth);
  add_number(state, n.unheld);
  add_number(state, n.spin);
  add_matrix(state, n.base.orientation.coeffs());
  for (const Vector3* v : {&n.base.position, &n.tip_position, &n.tip_force, &n.base_force, &n.base_torque,
                           &n.cutting_force, &n.friction_force, &n.lateral_force, &n.guide_force})
    add_matrix(state, *v);
}

void add_event(XXH3_state_t* state, const Event& event) {
  add_number(state, event.tick);
  add_number(state, event.needle);
  add_number(state, event.kind);
  add_number(state, event.region);
  add_matrix(state, event.position);
  add_number(state, event.force);
}

}  // namespace

void TraceHash::Free::operator()(XXH3_state_s* state) const { XXH3_freeState(state); }

TraceHash::TraceHash() : state_(XXH3_createState()) { XXH3_64bits_reset(state_.get()); }

void TraceHash::add(const Simulation& simulation) {
  add_report(simulation.report());
  add_number(state_.get(), hash(simulation.state()));
}

void TraceHash::add_report(const TickReport& report) {
  XXH3_state_t* state = state_.get();
  add_number(state, report.tick);
  add_number(state, report.time);
  add_number(state, report.flags);
  add_number(state, report.rows);
  add_number(state, report.solver);
  add_number(state, report.sweeps);
  add_number(state, report.newton_iterations);
  add_number(state, report.residual);
  add_number(state, report.imbalance);
  add_number(state, report.largest_force);
  for (const NeedleReport& needle : report.needles) add_needle(state, needle);
  for (const Event& event : report.events) add_event(state, event);
}

std::uint64_t TraceHash::value() const { return XXH3_64bits_digest(state_.get()); }

}  // namespace acus::test
