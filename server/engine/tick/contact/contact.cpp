// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/tick/contact/contact.h"

#include <array>
#include <cmath>

#include "server/engine/math/rotation.h"

namespace acus {

namespace {

// Fraction of the cap from which a force counts as at its cap.
constexpr double kAtCap = 1 - 1e-9;

// What forces of a kind are counted as: of Normal and Across, and of friction.
struct Counted {
  Vector3 NeedleForces::*main;
  Vector3 NeedleForces::*friction;
  bool at_tip;
  bool main_is_along = false;  // in the state; else across
};
using F = NeedleForces;
constexpr std::array<Counted, 11> kCounted{{
    {&F::cutting, &F::cutting, true, true},    // surface
    {&F::cutting, &F::cutting, true, true},    // border
    {&F::cutting, &F::cutting, true, true},    // cut
    {&F::lateral, &F::friction, true},         // tip
    {&F::lateral, &F::friction, true},         // tip_support
    {&F::lateral, &F::friction, false},        // vertex
    {&F::lateral, &F::friction, false},        // shaft_support
    {&F::lateral, &F::friction, false, true},  // shaft
    {&F::cutting, &F::cutting, false, true},   // hub
    {&F::guides, &F::guides, false},           // guide
    {&F::needles, &F::needles, false, true},   // needles
}};

const Counted& counted(const Contact& contact) { return kCounted[static_cast<std::size_t>(contact.kind)]; }

Row row_of(const Contact& contact) {
  Row row;
  row.needle = contact.needle;
  row.on_needle = contact.on_needle;
  row.in_tissue = contact.foot.point;
  row.patch = contact.foot.patch;
  row.other = contact.foot.needle;
  if (row.other >= 0) row.on_other = &contact.foot.on_needle;
  return row;
}

bool add(const Contact& contact, const Normal& hold, Rows& rows) {
  Row row = row_of(contact);
  const Spring& spring = hold.spring;
  row.n = hold.n;
  row.gap = hold.gap + spring.depth - spring.compliance * hold.before;
  row.compliance = spring.compliance + hold.compliance;
  row.stored = spring.stored;
  const int normal_row = rows.count();
  const bool added = rows.add(row, {LawKind::unilateral, hold.most}, hold.before);
  if (!added || !hold.friction) return added;
  const DiskFriction& disk = *hold.friction;
  row.compliance = disk.compliance;
  row.stored = 0;
  return rows.add_disk(row, hold.n, disk.slip,
                       {.limit = disk.friction, .normal_row = normal_row, .cohesion = disk.cohesion},
                       contact.state != nullptr ? contact.state->across : Vector3(Vector3::Zero()));
}

bool add(const Contact& contact, const Across& hold, Rows& rows) {
  Row row = row_of(contact);
  const Vector3& before = contact.state->across;
  Vector3 across[2];
  if (hold.tear)
    across[0] = hold.tear->along, across[1] = hold.tangent.cross(hold.tear->along);
  else
    perpendicular_basis(hold.tangent, across[0], across[1]);
  bool all = true;
  for (const Vector3& n : across) {
    row.n = n;
    row.gap = n.dot(hold.apart);
    const bool tears = hold.tear && &n == &across[0];
    row.compliance = tears ? hold.compliance : 0;
    const Law law = tears ? Law{LawKind::friction, hold.tear->force} : Law{.compliance = hold.compliance};
    all = rows.add(row, law, before.dot(n)) && all;
  }
  return all;
}

bool add(const Contact& contact, const Along& hold, Rows& rows) {
  Row row = row_of(contact);
  const ContactState& before = *contact.state;
  const FrictionCone& friction = hold.friction;
  row.n = hold.tangent;
  row.gap = hold.slip;
  row.compliance = hold.compliance;
  if (hold.radius == 0 && friction.back == 1 && friction.law.is_linear())
    return rows.add(row, {LawKind::friction, friction.law.threshold, friction.law.viscosity}, before.along);
  if (hold.radius == 0) return rows.add_cone(row, friction, before.along);
  Row about = row;
  about.compliance = 0;
  about.radius = hold.radius;
  about.gap = hold.turned;
  return rows.add_cone(row, about, friction, {before.along, before.torsion});
}

void remember(const Rows& rows, int i, bool main, const Contact& contact) {
  ContactState& state = *contact.state;
  const double lambda = rows.lambda()[i];
  if (rows.row(i).turns()) {
    state.torsion = lambda;
  } else if (std::holds_alternative<Along>(contact.hold)) {
    const Rows::Cone* cone = rows.find_cone(i);
    state.along = lambda;
    state.sliding = cone ? rows.answer(*cone).slips : std::abs(lambda) >= kAtCap * rows.law(i).limit;
  } else if (main && counted(contact).main_is_along) {
    state.along = lambda;
  } else {
    state.across += rows.force(i);
  }
}

}  // namespace

bool add_contact(Contact& contact, Rows& rows) {
  contact.first_row = rows.count();
  const bool all = std::visit([&](const auto& hold) { return add(contact, hold, rows); }, contact.hold);
  contact.rows = rows.count() - contact.first_row;
  return all;
}

void read_contact(const Rows& rows, const Contact& contact, std::span<NeedleForces> forces) {
  NeedleForces& on_needle = forces[static_cast<std::size_t>(contact.needle)];
  const Counted& as = counted(contact);
  for (int i = contact.first_row; i < contact.first_row + contact.rows; ++i) {
    const Row& row = rows.row(i);
    if (row.left_out) continue;
    const bool main = std::holds_alternative<Normal>(contact.hold) ? i == contact.first_row
                                                                   : std::holds_alternative<Across>(contact.hold);
    if (contact.state != nullptr) remember(rows, i, main, contact);
    if (row.turns()) continue;
    const Vector3 force = rows.force(i);
    if (row.acts_on_tissue()) on_needle.amounts += std::abs(rows.lambda()[i]);
    on_needle.*(main ? as.main : as.friction) += force;
    if (as.at_tip) on_needle.tip += force;
    if (row.other >= 0) forces[static_cast<std::size_t>(row.other)].needles -= force;
  }
}

bool at_most(const Rows& rows, const Contact& contact) {
  const int i = contact.first_row;
  return contact.rows > 0 && !rows.row(i).left_out && std::abs(rows.lambda()[i]) >= kAtCap * rows.law(i).limit;
}

}  // namespace acus
