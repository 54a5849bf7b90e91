// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/simulation/guide_hold.h"

#include "server/math/rotation.h"

namespace acus {

GuideHold::GuideHold(int index, int needle, const Guide& parameters, double h)
    : index_(index), needle_(needle), parameters_(parameters), motion_(parameters, h) {
  reset();
}

void GuideHold::reset() {
  motion_.reset();
  center_ = before_ = parameters_.pose.position;
  axis_ = parameters_.pose.orientation * Vector3::UnitX();
  s_ = 0;
  holds_ = false;
  across_.setZero();
  along_ = 0;
}

void GuideHold::advance(std::uint64_t tick) {
  before_ = center_;
  const Pose pose = motion_.advance(tick);
  center_ = pose.position;
  axis_ = pose.orientation * Vector3::UnitX();
}

void GuideHold::locate(const NeedleView& needle) {
  s_ = project_on_curve(needle, center_, axis_, s_);
  holds_ = s_ >= 0 && s_ <= needle.model.length;
}

bool GuideHold::build_rows(const NeedleView& needle, Rows& rows) const {
  if (!holds_) return true;
  Row row{needle_, RowRole::guide, index_, curve_point(needle.model, needle.shape, s_), {}, Vector3::Zero(), 0};
  const Vector3 apart = row.on_needle.position - center_;
  bool all = true;
  if (parameters_.play == 0) {
    Vector3 across[2];
    perpendicular_basis(axis_, across[0], across[1]);
    for (const Vector3& n : across) {
      row.n = n;
      row.gap = n.dot(apart);
      all = rows.add(row, {}, across_.dot(n)) && all;
    }
  } else if (const Vector3 off = apart - apart.dot(axis_) * axis_; off.norm() > 0) {
    row.n = -off.normalized();
    row.gap = parameters_.play - off.norm();
    all = rows.add(row, {LawKind::unilateral, kInfinity}, std::max(0.0, across_.dot(row.n)));
  }
  const double threshold = parameters_.friction * across_.norm();
  if (threshold == 0) return all;
  row.role = RowRole::guide_friction;
  row.n = axis_;
  row.gap = axis_.dot((row.on_needle.position - needle.start_position(s_)) - (center_ - before_));
  return rows.add(row, {LawKind::friction, threshold}, along_) && all;
}

void GuideHold::read_forces(const Rows& rows, NeedleReport& report) {
  across_.setZero();
  along_ = 0;
  for (int i = 0; i < rows.count(); ++i) {
    const Row& row = rows.row(i);
    if (row.index != index_ || acts_on_tissue(row.role)) continue;
    if (row.role == RowRole::guide) across_ += rows.force(i);
    if (row.role == RowRole::guide_friction) along_ = rows.lambda()[i];
    report.guide_force += rows.force(i);
  }
}

}  // namespace acus
