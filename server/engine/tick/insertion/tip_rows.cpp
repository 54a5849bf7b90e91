// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/tick/insertion/tip_rows.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "server/engine/math/rotation.h"
#include "server/engine/tick/insertion/obstacle.h"
#include "server/engine/tick/insertion/path_direction.h"
#include "server/engine/tick/insertion/tip_laws.h"

namespace acus {

namespace {

// Speed at which a tip behind a border is brought back.
constexpr double kRecoverySpeed = 0.1;  // m/s

// Distance of the tip from the obstacle along its normal (m). A tip that was behind the obstacle at the start of the
// tick by more than its dimple, torn out of its path or carried over a border, is brought back at `recovery` (m/s).
// The offset of a loaded tip whose dimple or patch has changed is closed at kSettlingSpeed.
double obstacle_gap(const InsertionView& at, const Obstacle& obstacle, const TipState& tip, double recovery) {
  const NeedleView& needle = at.needle;
  const double start = obstacle.dimple_before + height_before(at, obstacle), apart = height(at, obstacle);
  if (tip.contact == 0) return apart - std::min(0.0, start + recovery * needle.h);
  // A tip that slides follows hollows and bulges of the surface.
  const double travelled = (needle.tip().position - needle.start_tip()).norm();
  return apart - shrunk(start, kSettlingSpeed * needle.h + travelled);
}

// A row of the tip on the obstacle.
Row obstacle_row(const InsertionView& at, const Obstacle& obstacle, RowRole role, const Vector3& n) {
  Row row{
      .needle = at.needle_index, .role = role, .on_needle = at.needle.tip(), .in_tissue = {obstacle.material, {}, 0}};
  row.patch = obstacle.patch.points;
  row.n = n;
  return row;
}

// The tip against the obstacle, along its normal.
bool add_contact(const InsertionView& at, const Obstacle& obstacle, const TipState& tip, double puncture_force,
                 double gap, Rows& rows) {
  Row row = obstacle_row(at, obstacle, RowRole::contact, obstacle.at.normal);
  // The row has the whole force, or what is added to that of a cut.
  const double f = tip.contact, e = obstacle.dimple.compliance(obstacle.bears);
  row.compliance = e;
  row.gap = gap + obstacle.dimple.depth(obstacle.bears) - e * f;
  if (f == obstacle.bears) row.stored = obstacle.dimple.energy(f) - e * f * f / 2;
  return rows.add(row, {LawKind::unilateral, puncture_force}, f);
}

// The tip against the obstacle, along its surface.
bool add_contact_friction(const InsertionView& at, const Obstacle& obstacle, const TipState& tip, double friction,
                          double cohesion, int normal_row, Rows& rows) {
  if (friction == 0 && cohesion == 0) return true;
  Row row = obstacle_row(at, obstacle, RowRole::contact_friction, Vector3::Zero());
  row.compliance = obstacle.compliance_along;
  return rows.add_disk(row, obstacle.at.normal, slip(at, obstacle),
                       {.limit = friction, .normal_row = normal_row, .cohesion = cohesion}, tip.lateral);
}

bool add_border_contact(const InsertionView& at, const InsertionScratch& scratch, Rows& rows) {
  const Obstacle& obstacle = *scratch.located.obstacle;
  const Border& border = at.tissue.border(obstacle.material, obstacle.region);
  const double gap = obstacle_gap(at, obstacle, scratch.next.tip, kRecoverySpeed);
  const double share = tip_friction(at, obstacle, border.puncture_force, border.friction_contact).puncture_share;
  const TipState& tip = scratch.next.tip;
  const double by_cut = obstacle.bears - tip.contact;
  return add_contact(at, obstacle, tip, std::max(0.0, share * border.puncture_force - by_cut), gap, rows);
}

// Cohesion of a tip on a border: f_c ahead and sideways, 0 within 60 degrees of the way back, by the direction of the
// last tick's friction, which is against the slip.
double border_cohesion(const InsertionView& at, const Path& path, const TipState& tip) {
  const double cutting_force = at.tissue.interaction(path.end).cutting_force;
  const Vector3 ahead = end_tangent(at.tissue, path, at.needle.tip().tangent);
  const double back = ahead.dot(tip.lateral.stableNormalized());
  return cutting_force * std::clamp(1 - 2 * back, 0.0, 1.0);
}

// Along the cutting direction of stage 4, to which the lateral rows are orthogonal: in later iterations the tip may
// have turned.
bool add_cutting(const InsertionView& at, const Path& path, const InsertionScratch& scratch, Rows& rows) {
  const TipState& tip = scratch.next.tip;
  const double cutting_force = at.tissue.interaction(path.end).cutting_force;
  if (path.exited || cutting_force == 0) return true;
  Row row{at.needle_index, RowRole::cutting, -1, at.needle.tip(), {path.end, {}, 0}, -scratch.located.tip.cutting, 0};
  row.compliance = cutting_compliance(at, path, scratch.located.tip.ahead);
  row.gap = cutting_gap(at, path, tip, row.n, row.compliance);
  return rows.add(row, {LawKind::unilateral, cutting_force}, tip.cutting);
}

// The lateral rows of the tip.
bool add_lateral(const InsertionView& at, const InsertionScratch& scratch, Rows& rows) {
  const TipPlace& tip = scratch.located.tip;
  const HeldPlace place = held_tip(at, tip, at.tissue.relaxes() ? &scratch.next.memory->tip : nullptr);
  const Row row{at.needle_index, RowRole::tip_lateral, -1, at.needle.tip(), tip.point, Vector3::Zero(), 0};
  return add_across(at, row, place, scratch.next.tip.lateral, rows);
}

}  // namespace

bool add_across(const InsertionView& at, Row row, const HeldPlace& place, const Vector3& last, Rows& rows) {
  const auto tear = tear_limit(at, place, last);
  Vector3 across[2];
  if (tear)
    across[0] = tear->along, across[1] = place.tangent.cross(tear->along);
  else
    perpendicular_basis(place.tangent, across[0], across[1]);
  bool all = true;
  for (const Vector3& n : across) {
    row.n = n;
    row.gap = n.dot(place.apart);
    const bool tears = tear && &n == &across[0];
    row.compliance = tears ? place.compliance : 0;
    const Law law = tears ? Law{LawKind::friction, tear->force} : Law{.compliance = place.compliance};
    all = rows.add(row, law, last.dot(n)) && all;
  }
  return all;
}

double shrunk(double offset, double step) { return std::copysign(std::max(0.0, std::abs(offset) - step), offset); }

double cutting_gap(const InsertionView& at, const Path& path, const TipState& tip, const Vector3& n,
                   double compliance) {
  const double apart = n.dot(at.needle.tip().position - at.tissue.position(path.end));
  const double lag = compliance * tip.cutting;
  if (lag == 0) return apart;
  const double start = lag + n.dot(at.needle.start_tip() - at.tissue.start_position(path.end));
  return apart - shrunk(start, kSettlingSpeed * at.needle.h);
}

bool lies_on_border(const TissueView& tissue, const TipPlace& place) {
  return !place.at_end && place.point.u > 0 && tissue.border_face(place.point.a) && tissue.border_face(place.point.b);
}

bool add_surface_rows(const InsertionView& at, const InsertionScratch& scratch, Rows& rows) {
  assert(scratch.located.obstacle && (scratch.next.path < 0 || scratch.next.phase == Phase::through));
  const Obstacle& obstacle = *scratch.located.obstacle;
  const TipState& tip = scratch.next.tip;
  const Interaction& law = at.tissue.interaction(obstacle.material);
  const int normal_row = rows.count();
  const double gap = obstacle_gap(at, obstacle, tip, kSettlingSpeed);
  const auto [friction, share] = tip_friction(at, obstacle, law.puncture_force, law.friction_contact);
  return add_contact(at, obstacle, tip, share * law.puncture_force, gap, rows) &&
         add_contact_friction(at, obstacle, tip, friction, 0, normal_row, rows);
}

bool add_border_rows(const InsertionView& at, const Path& path, const InsertionScratch& scratch, Rows& rows) {
  assert(scratch.located.obstacle);
  const Obstacle& obstacle = *scratch.located.obstacle;
  const Border& border = at.tissue.border(obstacle.material, obstacle.region);
  const double friction = tip_friction(at, obstacle, border.puncture_force, border.friction_contact).friction;
  const double cohesion = border_cohesion(at, path, scratch.next.tip);
  const int normal_row = rows.count();
  return add_border_contact(at, scratch, rows) &&
         add_contact_friction(at, obstacle, scratch.next.tip, friction, cohesion, normal_row, rows);
}

bool add_path_rows(const InsertionView& at, const Path& path, const InsertionScratch& scratch, Rows& rows) {
  assert(scratch.next.path >= 0 && !path.empty());
  bool all = add_cutting(at, path, scratch, rows);
  if (scratch.located.obstacle) all = add_border_contact(at, scratch, rows) && all;
  all = add_lateral(at, scratch, rows) && all;
  const TipPlace& place = scratch.located.tip;
  if (!lies_on_border(at.tissue, place)) return all;
  const MaterialPoint& nearest = place.point.u < 0.5 ? place.point.a : place.point.b;
  const Row support{at.needle_index, RowRole::tip_lateral, -1, at.needle.tip(), {nearest, {}, 0}, Vector3::Zero(), 0};
  return add_support(
             at, support, [&](const MaterialPoint& p) { return tip_lateral_compliance(at, p, place.supported); },
             rows) &&
         all;
}

}  // namespace acus
