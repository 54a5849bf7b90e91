// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/state/report_hash.h"

namespace acus {

namespace {

// Numbers one after the other: structs as a whole would bring padding along.
template <class Number>
void add_number(Hasher& hasher, Number number) {
  static_assert(std::is_arithmetic_v<Number> || std::is_enum_v<Number>);
  hasher.bytes(&number, sizeof number);
}

template <class Derived>
void add_matrix(Hasher& hasher, const Eigen::MatrixBase<Derived>& matrix) {
  for (Eigen::Index j = 0; j < matrix.cols(); ++j)
    for (Eigen::Index i = 0; i < matrix.rows(); ++i) add_number(hasher, matrix(i, j));
}

void add_needle(Hasher& hasher, const NeedleReport& n) {
  add_number(hasher, n.command_seq);
  add_number(hasher, n.command_tick);
  add_number(hasher, n.phase);
  add_number(hasher, n.inserted_depth);
  add_number(hasher, n.unheld);
  add_number(hasher, n.spin);
  add_matrix(hasher, n.base.orientation.coeffs());
  for (const Vector3* v : {&n.base.position, &n.tip_position, &n.tip_force, &n.base_force, &n.base_torque,
                           &n.cutting_force, &n.friction_force, &n.lateral_force, &n.guide_force})
    add_matrix(hasher, *v);
}

void add_event(Hasher& hasher, const Event& event) {
  add_number(hasher, event.tick);
  add_number(hasher, event.needle);
  add_number(hasher, event.kind);
  add_number(hasher, event.region);
  add_matrix(hasher, event.position);
  add_number(hasher, event.force);
}

}  // namespace

void add_report(Hasher& hasher, const TickReport& report) {
  add_number(hasher, report.tick);
  add_number(hasher, report.time);
  add_number(hasher, report.flags);
  add_number(hasher, report.rows);
  add_number(hasher, report.solver);
  add_number(hasher, report.sweeps);
  add_number(hasher, report.newton_iterations);
  add_number(hasher, report.residual);
  add_number(hasher, report.imbalance);
  add_number(hasher, report.largest_force);
  for (const NeedleReport& needle : report.needles) add_needle(hasher, needle);
  for (const Event& event : report.events) add_event(hasher, event);
}

}  // namespace acus
