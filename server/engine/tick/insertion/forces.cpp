// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/tick/insertion/forces.h"

#include <cmath>

namespace acus {

namespace {

// Fraction of the cap from which a force counts as at its cap.
constexpr double kAtCap = 1 - 1e-9;

void read_row(const Rows& rows, int i, InsertionScratch& scratch, InsertionForces& forces) {
  const Row& row = rows.row(i);
  const double lambda = rows.lambda()[i];
  const auto at_cap = [&] { return std::abs(lambda) >= kAtCap * rows.law(i).limit; };
  const Vector3 force = rows.force(i);
  if (acts_on_tissue(row.role) && row.role != RowRole::torsion) forces.amounts += std::abs(lambda);
  Insertion& next = scratch.next;
  switch (row.role) {
    case RowRole::contact:
      next.tip.contact = lambda;
      scratch.puncturing = at_cap() && rows.delta()[i] < 0;
      forces.cutting += force;
      break;
    case RowRole::contact_friction:
      next.tip.lateral += force;
      forces.cutting += force;
      break;
    case RowRole::cutting:
      next.tip.cutting = lambda;
      scratch.cutting = at_cap();
      forces.cutting += force;
      break;
    case RowRole::tip_lateral:
      next.tip.lateral += force;
      forces.lateral += force;
      break;
    case RowRole::lateral:
      next.vertices[row.index].lateral += force;
      forces.lateral += force;
      break;
    case RowRole::friction: {
      const Rows::Cone* cone = rows.find_cone(i);
      next.vertices[row.index].friction = lambda;
      next.vertices[row.index].sliding = cone ? rows.answer(*cone).slips : at_cap();
      forces.friction += force;
      break;
    }
    case RowRole::shaft_contact:
      next.cells[row.index].contact = lambda;
      forces.lateral += force;
      break;
    case RowRole::shaft_contact_friction:
      next.cells[row.index].friction += force;
      forces.friction += force;
      break;
    case RowRole::torsion:
      next.vertices[row.index].torsion = lambda;
      break;
    case RowRole::guide:
    case RowRole::guide_friction:
    case RowRole::needle_contact:
    case RowRole::needle_friction:
      return;
  }
  if (row.index < 0) forces.tip += force;
}

}  // namespace

InsertionForces read_forces(const Rows& rows, int needle, InsertionScratch& scratch) {
  Insertion& next = scratch.next;
  scratch.puncturing = scratch.cutting = false;
  next.tip = TipState{};
  for (const ShaftPoint& p : scratch.located.shaft) {
    next.vertices[p.vertex].lateral.setZero();
    next.vertices[p.vertex].friction = 0;
  }
  for (ShaftCell& cell : next.cells) cell.contact = 0, cell.friction.setZero();
  InsertionForces forces;
  for (int i = 0; i < rows.count(); ++i)
    if (rows.row(i).needle == needle && !rows.row(i).left_out) read_row(rows, i, scratch, forces);
  for (const ShaftPoint& p : scratch.located.shaft) {
    VertexState& state = next.vertices[p.vertex];
    state.traction = p.owned > 0 ? state.friction / p.owned : 0;
  }
  return forces;
}

}  // namespace acus
