// SPDX-License-Identifier: GPL-3.0-or-later
// Stage 5 of an insertion: its rows, and what their forces mean after the solve.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "server/math/rotation.h"
#include "server/simulation/insertion.h"

namespace acus {

namespace {

// A force counts as at its cap from this fraction on.
constexpr double kAtCap = 1 - 1e-9;
// A tip that a tick took past a border comes back to it no faster than this.
constexpr double kRecoverySpeed = 0.1;  // m/s
// What a tip that bears force stands off by, because the give under it changes from element to element, is made good no
// faster than this: forces of the size that it takes are to change slowly.
constexpr double kSettlingSpeed = 5e-3;  // m/s
// A point holds as if it stood for at least this length of shaft (in spacings).
constexpr double kLeastOwned = 0.1;

// What is left of an offset (m) that is made good by `step` (m).
double shrunk(double offset, double step) { return std::copysign(std::max(0.0, std::abs(offset) - step), offset); }

double holding_length(double owned, double spacing) { return std::max(owned, kLeastOwned * spacing); }

}  // namespace

bool Insertion::build_rows(const NeedleView& needle, const TissueView& tissue, std::span<const Path> paths,
                           Rows& rows) {
  if (path_ < 0) return !obstacle_ || add_surface(needle, tissue, rows);
  const Path& path = paths[path_];
  bool all = !left_out_;
  if (obstacle_ && obstacle_->under) {
    all = add_border(needle, tissue, path, rows) && all;
  } else if (phase_ != Phase::through) {
    all = add_tip(needle, tissue, path, rows) && all;
  }
  for (const ShaftPoint& point : shaft_) all = add_shaft(needle, tissue, path, point, rows) && all;
  return all;
}

// What gives way under the tip (m/N) on a surface,
double Insertion::surface_compliance(const TissueView& tissue) const {
  const double puncture_force = tissue.interaction(obstacle_->material).puncture_force;
  return tissue.surface_compliance(obstacle_->material, parameters_.outer_diameter, puncture_force);
}

// at the end of its path,
double Insertion::cutting_compliance(const TissueView& tissue, const Path& path) const {
  return tissue.tip_compliance(path.end, parameters_.outer_diameter, tissue.interaction(path.end).cutting_force);
}

// and at a border, where what lies before the tip is pressed flat by f_c.
double Insertion::border_compliance(const TissueView& tissue, const Path& path) const {
  const double flat = tissue.interaction(path.end).cutting_force;
  return cutting_compliance(tissue, path) * (tip_.contact > flat ? flat / tip_.contact : 1);
}

// Distance of the tip from the obstacle along its normal (m). What the tip was behind it at the start of the tick, torn
// out of its path sideways or carried over a border by the tick before, and not by the give of what lies between, is
// made good at `recovery` (m/s), not at once; a recovery of 0 leaves it where it is. Likewise what a tip that already
// bears force stands off by, because the give has changed from one element to the next.
double Insertion::obstacle_gap(const NeedleView& needle, const TissueView& tissue, double recovery,
                               double compliance) const {
  const Vector3& n = obstacle_->at.normal;
  const double give = compliance * std::max(tip_.contact, tip_.cutting);
  const double start = give + n.dot(needle.start_tip() - tissue.start_position(obstacle_->material));
  const double before_it = obstacle_->under ? 0 : compliance * tip_.cutting;  // what is cut gives way first
  const double apart = before_it + n.dot(needle.tip().position - tissue.position(obstacle_->material));
  if (obstacle_->under && give > 0) return apart - shrunk(start, kSettlingSpeed * needle.h);
  return apart - std::min(0.0, start + recovery * needle.h);
}

// Distance of the tip from the path's end against the cutting direction n (m).
double Insertion::cutting_gap(const NeedleView& needle, const TissueView& tissue, const Path& path, const Vector3& n,
                              double compliance) const {
  const double apart = n.dot(needle.tip().position - tissue.position(path.end));
  const double give = compliance * tip_.cutting;
  if (give == 0) return apart;
  const double start = give + n.dot(needle.start_tip() - tissue.start_position(path.end));
  return apart - shrunk(start, kSettlingSpeed * needle.h);
}

// The tip against the obstacle, along its normal.
bool Insertion::add_contact(const NeedleView& needle, double puncture_force, double gap, double compliance,
                            Rows& rows) const {
  Row row{needle_, RowRole::contact, -1, needle.tip(), {obstacle_->material, {}, 0}, obstacle_->at.normal, gap};
  row.compliance = compliance;
  return rows.add(row, {LawKind::unilateral, puncture_force}, tip_.contact);
}

// And along its surface.
bool Insertion::add_contact_friction(const NeedleView& needle, const TissueView& tissue, double friction,
                                     double cohesion, int normal_row, Rows& rows) const {
  if (friction == 0 && cohesion == 0) return true;
  Row row{needle_, RowRole::contact_friction, -1, needle.tip(), {obstacle_->material, {}, 0}, Vector3::Zero(), 0};
  const Vector3 moved = (row.on_needle.position - tissue.position(obstacle_->material)) -
                        (needle.start_tip() - tissue.start_position(obstacle_->material));
  Vector3 across[2];
  perpendicular_basis(obstacle_->at.normal, across[0], across[1]);
  bool all = true;
  for (int k = 0; k < 2; ++k) {
    row.n = across[k];
    row.gap = row.n.dot(moved);
    const Law law{.kind = k == 0 ? LawKind::disk_first : LawKind::disk_second,
                  .limit = friction,
                  .normal_row = normal_row,
                  .cohesion = cohesion};
    all = rows.add(row, law, tip_.lateral.dot(row.n)) && all;
  }
  return all;
}

bool Insertion::add_surface(const NeedleView& needle, const TissueView& tissue, Rows& rows) const {
  const Interaction& law = tissue.interaction(obstacle_->material);
  const int normal_row = rows.count();
  const double compliance = surface_compliance(tissue), gap = obstacle_gap(needle, tissue, 0, compliance);
  return add_contact(needle, law.puncture_force, gap, compliance, rows) &&
         add_contact_friction(needle, tissue, law.friction_contact, 0, normal_row, rows);
}

bool Insertion::add_border_contact(const NeedleView& needle, const TissueView& tissue, const Path& path,
                                   Rows& rows) const {
  const Border& border = tissue.border(obstacle_->material, obstacle_->region);
  const double compliance = border_compliance(tissue, path);
  const double gap = obstacle_gap(needle, tissue, kRecoverySpeed, compliance);
  return add_contact(needle, border.puncture_force, gap, compliance, rows);
}

// A tip that rests against a border inside.
bool Insertion::add_border(const NeedleView& needle, const TissueView& tissue, const Path& path, Rows& rows) const {
  const double friction = tissue.border(obstacle_->material, obstacle_->region).friction_contact;
  const double cohesion = tissue.interaction(path.end).cutting_force;
  const int normal_row = rows.count();
  return add_border_contact(needle, tissue, path, rows) &&
         add_contact_friction(needle, tissue, friction, cohesion, normal_row, rows);
}

bool Insertion::add_tip(const NeedleView& needle, const TissueView& tissue, const Path& path, Rows& rows) const {
  const CurvePoint tip = needle.tip();
  bool all = true;
  const double cutting_force = tissue.interaction(path.end).cutting_force;
  if (!path.exited && cutting_force > 0) {
    Row row{needle_, RowRole::cutting, -1, tip, {path.end, {}, 0}, -cutting_direction(needle), 0};
    row.compliance = cutting_compliance(tissue, path);
    row.gap = cutting_gap(needle, tissue, path, row.n, row.compliance);
    all = rows.add(row, {LawKind::unilateral, cutting_force}, tip_.cutting);
  }
  if (obstacle_) all = add_border_contact(needle, tissue, path, rows) && all;
  Vector3 across[2];
  perpendicular_basis(tip_tangent_, across[0], across[1]);
  Vector3 apart = tip.position - tissue.position(tip_point_);
  const bool gives_way = !at_end_ || tissue.local_compliance == LocalCompliance::all;
  const double compliance =
      gives_way ? tissue.lateral_compliance(tip_point_.a, needle.model.diameter) / path.spacing : 0;
  if (at_end_) {
    apart -= needle.start_tip() - tissue.start_position(tip_point_.a) + compliance * tip_.lateral;
  } else {
    apart -= tip_offset_ * compliance * end_force_;
  }
  for (const Vector3& n : across) {
    const Row row{needle_, RowRole::tip_lateral, -1, tip, tip_point_, n, n.dot(apart), tip_softness_};
    all = rows.add(row, {.compliance = compliance}, tip_.lateral.dot(n)) && all;
  }
  if (at_end_) return all;
  const MaterialPoint& nearest = tip_point_.u < 0.5 ? tip_point_.a : tip_point_.b;
  const Row support{needle_, RowRole::tip_lateral, -1, tip, {nearest, {}, 0}, Vector3::Zero(), 0};
  return add_support(needle, needle.model.length, tissue, support, rows) && all;
}

bool Insertion::add_shaft(const NeedleView& needle, const TissueView& tissue, const Path& path,
                          const ShaftPoint& point, Rows& rows) const {
  const MaterialPoint& material = path.vertices[point.vertex];
  const CurvePoint on_needle = curve_point(needle.model, needle.shape, point.s);
  const Vector3 apart = on_needle.position - tissue.position(material);
  Row row{needle_, RowRole::lateral, point.vertex, on_needle, {material, {}, 0}, Vector3::Zero(), 0, point.softness};
  const double holding = holding_length(point.owned, path.spacing);
  const double compliance = tissue.lateral_compliance(material, needle.model.diameter) / holding;
  Vector3 across[2];
  perpendicular_basis(point.tangent, across[0], across[1]);
  bool all = true;
  for (const Vector3& n : across) {
    row.n = n;
    row.gap = n.dot(apart);
    all = rows.add(row, {.compliance = compliance}, memory_[point.vertex].lateral.dot(n)) && all;
  }
  row.softness = 0;
  // A tip this close to the vertex behind it has that one's support itself.
  const bool at_tip = !at_end_ && &point == &shaft_.back() && tip_point_.u < 0.5;
  if (!at_tip) all = add_support(needle, point.s, tissue, row, rows) && all;
  row.n = point.tangent;
  row.compliance = tissue.axial_compliance(material, needle.model.diameter) / holding;
  return add_friction(needle, tissue, point, row, rows) && all;
}

// A border that the path lies on keeps the needle, at s, out of the region behind it, however soft the tissue on this side
// is. A needle whose tip has pressed that tissue flat comes in behind the border and is brought out slowly.
bool Insertion::add_support(const NeedleView& needle, double s, const TissueView& tissue, Row row, Rows& rows) const {
  const auto normal = tissue.border_normal(row.in_tissue.a);
  if (!normal) return true;
  row.n = *normal;
  row.gap = row.n.dot(row.on_needle.position - tissue.position(row.in_tissue.a));
  if (tissue.local_compliance == LocalCompliance::all) {
    const double start = row.n.dot(needle.start_position(s) - tissue.start_position(row.in_tissue.a));
    row.gap -= std::min(0.0, start + kSettlingSpeed * needle.h);
  }
  return rows.add(row, {LawKind::unilateral, kInfinity}, 0);
}

bool Insertion::add_friction(const NeedleView& needle, const TissueView& tissue, const ShaftPoint& point, Row& row,
                             Rows& rows) const {
  const MaterialPoint& material = row.in_tissue.a;
  const Interaction& law = tissue.interaction(material);
  const Memory& memory = memory_[point.vertex];
  const double normal = point.owned * std::numbers::pi * needle.model.diameter * *law.pressure;
  const auto threshold = [&](bool slips) { return normal * (slips ? law.friction_dynamic : law.friction_static); };
  const double viscosity = point.owned * law.friction_viscous / needle.h;
  bool all = true;
  if (threshold(false) > 0 || viscosity > 0) {
    const Vector3 before = needle.start_position(point.s) - tissue.start_position(material);
    row.role = RowRole::friction;
    row.gap = row.n.dot(row.on_needle.position - tissue.position(material) - before) -
              row.compliance * memory.traction * point.owned;
    all = rows.add(row, {LawKind::friction, threshold(memory.sliding), viscosity}, memory.friction);
  }
  const double share = parameters_.torsional_friction;
  if (share * threshold(false) == 0) return all;
  row.role = RowRole::torsion;
  row.compliance = 0;
  row.radius = needle.model.diameter / 2;
  row.gap = row.radius * row.n.dot(needle.turned(row.on_needle) -
                                   material_rotation(tissue.mesh, tissue.x_start, tissue.x, material.tetrahedron));
  return rows.add(row, {LawKind::friction, share * threshold(memory.turning)}, memory.torsion) && all;
}

void Insertion::read_forces(const Rows& rows, NeedleReport& report) {
  puncturing_ = cutting_ = false;
  tip_ = TipMemory{};
  report.tip_force.setZero();
  report.cutting_force.setZero();
  report.friction_force.setZero();
  report.lateral_force.setZero();
  for (const ShaftPoint& p : shaft_) {
    memory_[p.vertex].lateral.setZero();
    memory_[p.vertex].friction = 0;
  }

  for (int i = 0; i < rows.count(); ++i) {
    const Row& row = rows.row(i);
    if (row.needle != needle_) continue;
    const double lambda = rows.lambda()[i];
    const Vector3 force = rows.force(i);
    switch (row.role) {
      case RowRole::contact:
        tip_.contact = lambda;
        puncturing_ = lambda >= kAtCap * rows.law(i).limit && rows.delta()[i] < 0;
        report.cutting_force += force;
        break;
      case RowRole::contact_friction:
        tip_.lateral += force;
        report.cutting_force += force;
        break;
      case RowRole::cutting:
        tip_.cutting = lambda;
        cutting_ = lambda >= kAtCap * rows.law(i).limit;
        report.cutting_force += force;
        break;
      case RowRole::tip_lateral:
        tip_.lateral += force;
        report.lateral_force += force;
        break;
      case RowRole::lateral:
        memory_[row.index].lateral += force;
        report.lateral_force += force;
        break;
      case RowRole::friction:
        memory_[row.index].friction = lambda;
        memory_[row.index].sliding = std::abs(lambda) >= kAtCap * rows.law(i).limit;
        report.friction_force += force;
        break;
      case RowRole::torsion:
        memory_[row.index].torsion = lambda;
        memory_[row.index].turning = std::abs(lambda) >= kAtCap * rows.law(i).limit;
        break;
      case RowRole::guide:
      case RowRole::guide_friction:
        continue;
    }
    if (row.index < 0) report.tip_force += force;
  }
  for (const ShaftPoint& p : shaft_) {
    Memory& memory = memory_[p.vertex];
    memory.traction = p.owned > 0 ? memory.friction / p.owned : 0;
  }
  if (at_end_ && !(obstacle_ && obstacle_->under)) end_force_ = tip_.lateral;
}

}  // namespace acus
