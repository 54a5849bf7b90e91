// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/tick/insertion/tip_rows.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "server/engine/math/rotation.h"
#include "server/engine/tick/insertion/path_tangents.h"
#include "server/engine/tick/insertion/tip_friction.h"
#include "server/engine/tick/insertion/tip_compliance.h"

namespace acus {

namespace {

// A tip that a tick took past a border comes back to it no faster than this.
constexpr double kRecoverySpeed = 0.1;  // m/s
// What a tip that bears force stands off by, because the give under it changes from element to element, is made good no
// faster than this: forces of the size that it takes are to change slowly.
constexpr double kSettlingSpeed = 5e-3;  // m/s

// What is left of an offset (m) that is made good by `step` (m).
double shrunk(double offset, double step) { return std::copysign(std::max(0.0, std::abs(offset) - step), offset); }

// What an obstacle's contact acts on, as it was at the start of the tick and is now: a point, or the mean of a patch.
struct Footing {
  Vector3 start, now;
  double rise = 0;  // m, of the surface over it, along the obstacle's normal

  Footing(const TissueView& tissue, const Obstacle& obstacle, const TipMemory& tip) {
    start = tissue.start_position(obstacle.material);
    if (!obstacle.patch) {
      now = tissue.position(obstacle.material);
      return;
    }
    const Vector3 surface = start;
    start = obstacle.patch->middle;
    now = mean_position(tissue.mesh, tissue.x, *obstacle.patch);
    rise = tip.contact > 0 ? obstacle.patch->rise : obstacle.at.normal.dot(surface - start);
  }
};

// Distance of the tip from the obstacle along its normal (m). What the tip was behind it at the start of the tick, torn
// out of its path sideways or carried over a border by the tick before, and not by the give of what lies between, is
// made good at `recovery` (m/s), not at once. Likewise what a tip that already bears force stands off by, because the
// give or the patch under it has changed.
double obstacle_gap(const InsertionView& at, const Obstacle& obstacle, const TipMemory& tip, double recovery) {
  const NeedleView& needle = at.needle;
  const Vector3& n = obstacle.at.normal;
  const Footing footing(at.tissue, obstacle, tip);
  const double start = obstacle.compliance * tip.contact + n.dot(needle.start_tip() - footing.start) - footing.rise;
  const double apart = n.dot(needle.tip().position - footing.now) - footing.rise;
  if (!obstacle.patch || tip.contact == 0) return apart - std::min(0.0, start + recovery * needle.h);
  // A tip that slides comes to other places, and to a hollow or a bulge no later than to these.
  const double travelled = (needle.tip().position - needle.start_tip()).norm();
  return apart - shrunk(start, kSettlingSpeed * needle.h + travelled);
}

// A row of the tip on the obstacle.
Row obstacle_row(const InsertionView& at, const Obstacle& obstacle, RowRole role, const Vector3& n) {
  Row row{.needle = at.needle_index, .role = role, .on_needle = at.needle.tip(), .in_tissue = {obstacle.material, {}, 0}};
  if (obstacle.patch) row.patch = obstacle.patch->all();
  row.n = n;
  return row;
}

// The tip against the obstacle, along its normal.
bool add_contact(const InsertionView& at, const Obstacle& obstacle, const TipMemory& tip, double puncture_force,
                 double gap, Rows& rows) {
  Row row = obstacle_row(at, obstacle, RowRole::contact, obstacle.at.normal);
  row.gap = gap;
  row.compliance = obstacle.compliance;
  return rows.add(row, {LawKind::unilateral, puncture_force}, tip.contact);
}

// And along its surface.
bool add_contact_friction(const InsertionView& at, const Obstacle& obstacle, const TipMemory& tip, double friction,
                          double cohesion, int normal_row, Rows& rows) {
  if (friction == 0 && cohesion == 0) return true;
  const Footing footing(at.tissue, obstacle, tip);
  const Vector3 moved = (at.needle.tip().position - footing.now) - (at.needle.start_tip() - footing.start);
  Vector3 across[2];
  perpendicular_basis(obstacle.at.normal, across[0], across[1]);
  bool all = true;
  for (int k = 0; k < 2; ++k) {
    Row row = obstacle_row(at, obstacle, RowRole::contact_friction, across[k]);
    row.gap = row.n.dot(moved);
    const Law law{.kind = k == 0 ? LawKind::disk_first : LawKind::disk_second,
                  .limit = friction,
                  .normal_row = normal_row,
                  .cohesion = cohesion};
    all = rows.add(row, law, tip.lateral.dot(row.n)) && all;
  }
  return all;
}

bool add_border_contact(const InsertionView& at, const InsertionWork& work, Rows& rows) {
  const Obstacle& obstacle = *work.located.obstacle;
  const Border& border = at.tissue.border(obstacle.material, obstacle.region);
  const double gap = obstacle_gap(at, obstacle, work.next.tip, kRecoverySpeed);
  const double share = tip_friction(at, obstacle, border.puncture_force, border.friction_contact).puncture_share;
  return add_contact(at, obstacle, work.next.tip, share * border.puncture_force, gap, rows);
}

// What a tip on a border has to cut as it slides: all of f_c ahead and aside, nothing within 60 degrees of its way back.
// By the force of the last tick, which is against the slip.
double border_cohesion(const InsertionView& at, const Path& path, const TipMemory& tip) {
  const double cutting_force = at.tissue.interaction(path.end).cutting_force;
  const Vector3 ahead = end_tangent(at.tissue, path, at.needle.tip().tangent);
  const double back = ahead.dot(tip.lateral.stableNormalized());
  return cutting_force * std::clamp(1 - 2 * back, 0.0, 1.0);
}

// Along the direction that stage 4 has found, to which the tip's hold is orthogonal: in later iterations the tip may have
// turned.
bool add_cutting(const InsertionView& at, const Path& path, const InsertionWork& work, Rows& rows) {
  const TipMemory& tip = work.next.tip;
  const double cutting_force = at.tissue.interaction(path.end).cutting_force;
  if (path.exited || cutting_force == 0) return true;
  Row row{at.needle_index, RowRole::cutting, -1, at.needle.tip(), {path.end, {}, 0}, -work.located.tip.cutting, 0};
  row.compliance = cutting_compliance(at, path, work.located.tip.ahead);
  row.gap = cutting_gap(at, path, tip, row.n, row.compliance);
  return rows.add(row, {LawKind::unilateral, cutting_force}, tip.cutting);
}

// The tip across its way.
bool add_hold(const InsertionView& at, const InsertionWork& work, Rows& rows) {
  const TipPlace& place = work.located.tip;
  const CurvePoint tip = at.needle.tip();
  const double compliance = hold_compliance(at, place.point.a, place.held);
  const Vector3 apart = tip.position - at.tissue.position(place.point);
  Vector3 across[2];
  perpendicular_basis(place.tangent, across[0], across[1]);
  bool all = true;
  for (const Vector3& n : across) {
    const Row row{at.needle_index, RowRole::tip_lateral, -1, tip, place.point, n, n.dot(apart)};
    all = rows.add(row, {.compliance = compliance}, work.next.tip.lateral.dot(n)) && all;
  }
  return all;
}

}  // namespace

double cutting_gap(const InsertionView& at, const Path& path, const TipMemory& tip, const Vector3& n,
                   double compliance) {
  const double apart = n.dot(at.needle.tip().position - at.tissue.position(path.end));
  const double give = compliance * tip.cutting;
  if (give == 0) return apart;
  const double start = give + n.dot(at.needle.start_tip() - at.tissue.start_position(path.end));
  return apart - shrunk(start, kSettlingSpeed * at.needle.h);
}

bool add_surface_rows(const InsertionView& at, const InsertionWork& work, Rows& rows) {
  assert(work.located.obstacle && (work.next.path < 0 || work.next.phase == Phase::through));
  const Obstacle& obstacle = *work.located.obstacle;
  const TipMemory& tip = work.next.tip;
  const Interaction& law = at.tissue.interaction(obstacle.material);
  const int normal_row = rows.count();
  const double gap = obstacle_gap(at, obstacle, tip, kSettlingSpeed);
  const auto [friction, share] = tip_friction(at, obstacle, law.puncture_force, law.friction_contact);
  return add_contact(at, obstacle, tip, share * law.puncture_force, gap, rows) &&
         add_contact_friction(at, obstacle, tip, friction, 0, normal_row, rows);
}

bool add_border_rows(const InsertionView& at, const Path& path, const InsertionWork& work, Rows& rows) {
  assert(work.located.obstacle);
  const Obstacle& obstacle = *work.located.obstacle;
  const Border& border = at.tissue.border(obstacle.material, obstacle.region);
  const double friction = tip_friction(at, obstacle, border.puncture_force, border.friction_contact).friction;
  const double cohesion = border_cohesion(at, path, work.next.tip);
  const int normal_row = rows.count();
  return add_border_contact(at, work, rows) &&
         add_contact_friction(at, obstacle, work.next.tip, friction, cohesion, normal_row, rows);
}

bool add_path_rows(const InsertionView& at, const Path& path, const InsertionWork& work, Rows& rows) {
  assert(work.next.path >= 0 && !path.empty());
  bool all = add_cutting(at, path, work, rows);
  if (work.located.obstacle) all = add_border_contact(at, work, rows) && all;
  all = add_hold(at, work, rows) && all;
  const TipPlace& place = work.located.tip;
  if (place.at_end) return all;
  const MaterialPoint& nearest = place.point.u < 0.5 ? place.point.a : place.point.b;
  const Row support{at.needle_index, RowRole::tip_lateral, -1, at.needle.tip(), {nearest, {}, 0}, Vector3::Zero(), 0};
  return add_support(at, support, [&](const MaterialPoint& p) { return hold_compliance(at, p, place.held); }, rows) && all;
}

}  // namespace acus
