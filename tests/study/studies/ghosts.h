// SPDX-License-Identifier: GPL-3.0-or-later
// The invariant that every lay person takes for granted: a tip inside the deformed tissue is in a path or in contact.
#pragma once

#include "server/engine/models/geometry/surface.h"
#include "server/engine/tick/insertion/insertion.h"
#include "server/engine/tick/simulation.h"

namespace acus {

// Whether a needle's tip stands deeper in the tissue than goes unnoticed, and neither a path nor a contact knows of it.
// A tip that is through is out of its path again. `surface`: of the simulation's mesh.
inline bool is_ghost(const Simulation& simulation, const Surface& surface, int needle) {
  const NeedleReport& report = simulation.report().needles[static_cast<std::size_t>(needle)];
  const bool out = report.phase == Phase::free || (report.phase == Phase::through && report.tip_force.isZero(0));
  if (!out) return false;
  const Matrix3X x = simulation.tissue_positions();
  if (x.cols() == 0 || find_tetrahedron(simulation.mesh(), x, report.tip_position) < 0) return false;
  return (surface.closest(x, report.tip_position).position - report.tip_position).norm() > kUnnoticedDepth;
}

}  // namespace acus
