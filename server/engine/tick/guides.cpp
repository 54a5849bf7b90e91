// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/tick/guides.h"

#include <cassert>

#include "server/engine/math/rotation.h"

namespace acus {

void begin_guide(const BaseLimits& limits, double h, const GuideState& state, const std::optional<Command>& newest,
                 std::uint64_t tick, GuideScratch& scratch) {
  assert(h > 0);
  scratch.next = state;
  scratch.next.motion = follow(limits, h, state.motion, newest, tick);
  const Pose pose = scratch.next.motion.spun_pose();
  scratch.before = state.motion.pose.position;
  scratch.center = pose.position;
  scratch.axis = pose.orientation * Vector3::UnitX();
}

void locate_guide(const NeedleView& needle, GuideScratch& scratch) {
  double& s = scratch.next.s;
  s = project_on_curve(needle, scratch.center, scratch.axis, s);
  scratch.holds = s >= 0 && s <= needle.model.length;
}

bool add_guide_rows(const Guide& parameters, int index, int needle_index, const NeedleView& needle,
                    const GuideScratch& scratch, Rows& rows) {
  assert(parameters.play >= 0 && needle_index >= 0);
  if (!scratch.holds) return true;
  const GuideState& next = scratch.next;
  Row row{needle_index, RowRole::guide, index, curve_point(needle.model, needle.shape, next.s), {}, Vector3::Zero(), 0};
  const Vector3 apart = row.on_needle.position - scratch.center;
  bool all = true;
  if (parameters.play == 0) {
    Vector3 across[2];
    perpendicular_basis(scratch.axis, across[0], across[1]);
    for (const Vector3& n : across) {
      row.n = n;
      row.gap = n.dot(apart);
      all = rows.add(row, {}, next.across.dot(n)) && all;
    }
  } else if (const Vector3 off = apart - apart.dot(scratch.axis) * scratch.axis; off.norm() > 0) {
    row.n = -off.normalized();
    row.gap = parameters.play - off.norm();
    all = rows.add(row, {LawKind::unilateral, kInfinity}, std::max(0.0, next.across.dot(row.n)));
  }
  const double threshold = parameters.friction * next.across.norm();
  if (threshold == 0) return all;
  row.role = RowRole::guide_friction;
  row.n = scratch.axis;
  row.gap =
      scratch.axis.dot((row.on_needle.position - needle.start_position(next.s)) - (scratch.center - scratch.before));
  return rows.add(row, {LawKind::friction, threshold}, next.along) && all;
}

Vector3 read_guide_forces(const Rows& rows, int index, GuideScratch& scratch) {
  GuideState& next = scratch.next;
  next.across.setZero();
  next.along = 0;
  Vector3 force = Vector3::Zero();
  for (int i = 0; i < rows.count(); ++i) {
    const Row& row = rows.row(i);
    if (row.index != index || !is_of_guide(row.role)) continue;
    if (row.role == RowRole::guide) next.across += rows.force(i);
    if (row.role == RowRole::guide_friction) next.along = rows.lambda()[i];
    force += rows.force(i);
  }
  return force;
}

}  // namespace acus
