// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/tick/insertion/finding/obstacle.h"

#include <algorithm>
#include <cmath>

#include "server/engine/tick/insertion/spring_memory.h"
#include "server/engine/tick/insertion/tip_laws.h"

namespace acus {

namespace {

void bear_tip(const InsertionView& at, const Surface& surface, int behind, const Insertion& state, Obstacle& obstacle) {
  bear_on_patch(at.tissue, surface, behind, at.parameters.outer_diameter,
                at.tissue.puncture_force(obstacle.material, behind), tip_of(at), state.tip.contact.creep, obstacle);
}

// What faces away from the tip, past an edge, bears the side of the needle there: a needle that is drawn back does not
// hook into the tissue. Nor does it puncture, or one at rest that bore more as it was drawn.
void bear_beside(const InsertionView& at, Obstacle& obstacle) {
  const NeedleView& needle = at.needle;
  const Vector3 along = curve_point(needle.model, needle.start, needle.model.length).tangent;
  const double away = obstacle.at.normal.dot(along);
  if (away > 0) obstacle.at.normal = (obstacle.at.normal - away * along).stableNormalized();
  const double f_p = at.tissue.puncture_force(obstacle.material, -1);
  const double most = tip_friction(at, obstacle, f_p, 0).puncture_share * f_p;
  const double moves = along.dot(curve_point(needle.model, needle.shape, 0).position - needle.start_position(0));
  obstacle.yields = away <= 0 && (moves > 0 || (moves == 0 && obstacle.bears < most));
}

// Share of a force along the cutting direction that is against a border.
double towards(const InsertionView& at, const Obstacle& border) {
  return -border.at.normal.dot(at.cutting_direction());
}

// All that a tip inside bears, beside or on a border (N, world).
Vector3 force_of_tip(const InsertionView& at, const Obstacle& border, const TipState& tip) {
  return tip.contact.along * border.at.normal + tip.contact.across - tip.cut.along * at.cutting_direction();
}

// What a border bears along its normal of a tip that has contact with it, or cuts before it (N): not more than f_p.
// `force`: force_of_tip().
double contact_of(const InsertionView& at, const Obstacle& border, const TipState& tip, const Vector3& force) {
  if (tip.cut.along == 0) return tip.contact.along;
  const double most = std::max(tip.contact.along, at.tissue.puncture_force(border.material, border.region));
  return std::clamp(border.at.normal.dot(force), tip.contact.along, most);
}

// Of what bears an end, now; at the start of the tick it is patch.middle.
Vector3 place(const TissueView& tissue, const Obstacle& obstacle) {
  return mean_position(tissue.mesh, tissue.x, obstacle.patch.points);
}

}  // namespace

Obstacle surface_ahead(const InsertionView& at, const SurfacePoint& point, const Insertion& state) {
  Obstacle obstacle;
  obstacle.at = point;
  obstacle.material = at.tissue.surface.material(point);
  obstacle.region = at.tissue.region(obstacle.material);
  obstacle.bears = state.tip.contact.along;
  bear_tip(at, at.tissue.surface, -1, state, obstacle);
  bear_beside(at, obstacle);
  if (obstacle.bears == 0)
    obstacle.rise = obstacle.at.normal.dot(at.tissue.start_position(obstacle.material) - obstacle.patch.middle);
  obstacle.dimple_before = obstacle.dimple.depth(obstacle.bears);
  return obstacle;
}

Obstacle border_ahead(const InsertionView& at, int region, const Vector3& p, const Insertion& state) {
  const Surface& surface = at.tissue.borders.surface(region);
  Obstacle obstacle;
  obstacle.region = region;
  obstacle.at = surface.closest(at.tissue.x, p);
  obstacle.material = surface.material(obstacle.at);
  obstacle.bears = contact_of(at, obstacle, state.tip, force_of_tip(at, obstacle, state.tip));
  bear_tip(at, surface, region, state, obstacle);
  const Vector3 force = force_of_tip(at, obstacle, state.tip);
  obstacle.bears = contact_of(at, obstacle, state.tip, force);
  obstacle.dimple_before = obstacle.dimple.depth(obstacle.bears);
  const double size = std::min(force.norm(), at.tissue.puncture_force(obstacle.material, region));
  const DimpleSpring& dimple = obstacle.dimple;
  obstacle.compliance_along =
      size > 0 ? dimple.depth(size) / dimple.at_rest(size) / dimple.stiffening() : dimple.compliance(0);
  return obstacle;
}

void bear_on_patch(const TissueView& tissue, const Surface& surface, int behind, double d, double f_p,
                   const NeedleEnd& end, const Creep& creep, Obstacle& obstacle) {
  const MaterialPoint& p = obstacle.material;
  const double below = std::max(0.0, -obstacle.at.normal.dot(end.before - tissue.start_position(p)));
  const double load =
      disc_load(tissue.indented(p, behind), tissue.element_sizes[p.tetrahedron], d, f_p, obstacle.bears, below);
  const double radius = tissue.contact_radius(p, d, load, behind);
  obstacle.patch = make_contact_patch(tissue, surface, p, radius, behind < 0 ? d : 0);
  obstacle.at.normal = obstacle.patch.normal;
  obstacle.rise = obstacle.patch.rise;
  obstacle.dimple = tissue.dimple_spring(p, d, load, behind);
  obstacle.dimple.relax(tissue.relaxation_of(p, behind), creep.along);
}

double height_before(const Obstacle& obstacle, const NeedleEnd& end) {
  return obstacle.at.normal.dot(end.before - obstacle.patch.middle) - obstacle.rise;
}

double height(const TissueView& tissue, const Obstacle& obstacle, const NeedleEnd& end) {
  return obstacle.at.normal.dot(end.now.position - place(tissue, obstacle)) - obstacle.rise;
}

Vector3 slip(const TissueView& tissue, const Obstacle& obstacle, const NeedleEnd& end) {
  return (end.now.position - end.before) - (place(tissue, obstacle) - obstacle.patch.middle);
}

double shrunk(double offset, double step) { return std::copysign(std::max(0.0, std::abs(offset) - step), offset); }

// The end bears the whole force, or what is added to that of a cut.
Contact on_obstacle(const InsertionView& at, const Obstacle& obstacle, ContactKind kind, const NeedleEnd& end,
                    double most, double recovery, ContactState& state) {
  const Spring& seat = obstacle.seat;
  const double f = state.along, e = obstacle.dimple.compliance(obstacle.bears), h = at.needle.h;
  const double start = obstacle.dimple_before + height_before(obstacle, end);
  // An end that slides follows hollows and bulges of the surface.
  const double travelled = (end.now.position - end.before).norm() + end.turned;
  const double offset = f == 0 ? std::min(0.0, start + recovery * h) : shrunk(start, kSettlingSpeed * h + travelled);
  Spring spring{obstacle.dimple.depth(obstacle.bears) + seat.depth, e + seat.compliance};
  if (f == obstacle.bears) spring.stored = obstacle.dimple.energy(f) - e * f * f / 2 + seat.stored;
  Contact contact{.kind = kind, .needle = at.needle_index, .on_needle = end.now, .state = &state};
  contact.foot.point.a = obstacle.material;
  contact.foot.patch = obstacle.patch.points;
  contact.hold = Normal{.n = obstacle.at.normal,
                        .gap = height(at.tissue, obstacle, end) - offset,
                        .most = most,
                        .before = f,
                        .spring = spring};
  return contact;
}

std::optional<DiskFriction> friction_along(const TissueView& tissue, const Obstacle& obstacle, const NeedleEnd& end,
                                           double friction, double cohesion) {
  if (friction == 0 && cohesion == 0) return std::nullopt;
  return DiskFriction{slip(tissue, obstacle, end) + obstacle.creeps_along, friction, cohesion,
                      obstacle.compliance_along};
}

BorderAhead border_on_the_way(const InsertionView& at, const Path& path, const Obstacle& border, double height) {
  constexpr double kGrazing = 1e-3;  // sine of the angle below which the direction misses the border
  const double share = towards(at, border);
  if (share <= kGrazing) return {};
  const double cutting_force = at.tissue.interaction(path.end).cutting_force;
  return {height / share, border.dimple.depth(share * cutting_force) / share};
}

void press_on_border(const InsertionView& at, const Obstacle& border, TipState& tip) {
  if (tip.cut.along == 0) return;
  const Vector3 force = force_of_tip(at, border, tip), &n = border.at.normal;
  tip.contact.along = contact_of(at, border, tip, force);
  tip.contact.across = force - n.dot(force) * n;
  tip.cut.along = 0;
}

void cut_beside_border(const InsertionView& at, const Path& path, const Obstacle& border, TipState& tip) {
  const Vector3 force = force_of_tip(at, border, tip), direction = at.cutting_direction();
  const double most = at.tissue.interaction(path.end).cutting_force;
  const double cutting = std::clamp(-direction.dot(force), 0.0, most);
  tip.contact.along = 0;
  tip.contact.across = force - direction.dot(force) * direction;
  tip.cut.along = cutting;
}

Vector3 beside_dimple(const InsertionView& at, const Path& path, const InsertionScratch& scratch,
                      const MaterialPoint& vertex) {
  const std::optional<Obstacle>& border = scratch.located.obstacle;
  const bool pressed = border && scratch.next.border == border->region && border->dimple_before > 0;
  if (!pressed || !at.tissue.border_face(vertex)) return Vector3::Zero();
  const LoadRadii radii = border->dimple.radii(border->bears);
  if (radii.resolved()) return Vector3::Zero();
  const Dent dent{at.tissue.position(path.end), -border->dimple_before * border->at.normal, radii};
  return dent.share(at.tissue.position(vertex)) * dent.move;
}

}  // namespace acus
