// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/tick/insertion/finding/tip_contacts.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "server/engine/math/rotation.h"
#include "server/engine/tick/insertion/finding/obstacle.h"
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
  if (tip.contact.along == 0) return apart - std::min(0.0, start + recovery * needle.h);
  // A tip that slides follows hollows and bulges of the surface.
  const double travelled = (needle.tip().position - needle.start_tip()).norm();
  return apart - shrunk(start, kSettlingSpeed * needle.h + travelled);
}

Contact on_obstacle(const InsertionView& at, const Obstacle& obstacle, ContactKind kind, const Normal& hold,
                    ContactState& state) {
  Contact contact{.kind = kind, .needle = at.needle_index, .on_needle = at.needle.tip(), .state = &state};
  contact.foot.point.a = obstacle.material;
  contact.foot.patch = obstacle.patch.points;
  contact.hold = hold;
  return contact;
}

// Of the tip, along the obstacle's normal. It bears the whole force, or what is added to that of a cut.
Normal against(const Obstacle& obstacle, const TipState& tip, double puncture_force, double gap) {
  const double f = tip.contact.along, e = obstacle.dimple.compliance(obstacle.bears);
  Spring spring{obstacle.dimple.depth(obstacle.bears), e};
  if (f == obstacle.bears) spring.stored = obstacle.dimple.energy(f) - e * f * f / 2;
  return {.n = obstacle.at.normal, .gap = gap, .most = puncture_force, .before = f, .spring = spring};
}

// None where it can bear nothing.
std::optional<DiskFriction> friction_along(const InsertionView& at, const Obstacle& obstacle, double friction,
                                           double cohesion) {
  if (friction == 0 && cohesion == 0) return std::nullopt;
  return DiskFriction{slip(at, obstacle) + obstacle.creeps_along, friction, cohesion, obstacle.compliance_along};
}

Normal against_border(const InsertionView& at, const InsertionScratch& scratch) {
  const Obstacle& obstacle = *scratch.located.obstacle;
  const Border& border = at.tissue.border(obstacle.material, obstacle.region);
  const double gap = obstacle_gap(at, obstacle, scratch.next.tip, kRecoverySpeed);
  const double share = tip_friction(at, obstacle, border.puncture_force, border.friction_contact).puncture_share;
  const TipState& tip = scratch.next.tip;
  const double by_cut = obstacle.bears - tip.contact.along;
  return against(obstacle, tip, std::max(0.0, share * border.puncture_force - by_cut), gap);
}

// Cohesion of a tip on a border: f_c ahead and sideways, 0 within 60 degrees of the way back, by the direction of the
// last tick's friction, which is against the slip.
double border_cohesion(const InsertionView& at, const Path& path, const TipState& tip) {
  const double cutting_force = at.tissue.interaction(path.end).cutting_force;
  const Vector3 ahead = end_tangent(at.tissue, path, at.needle.tip().tangent);
  const double back = ahead.dot(tip.contact.across.stableNormalized());
  return cutting_force * std::clamp(1 - 2 * back, 0.0, 1.0);
}

// Distance of the tip from the path's end against the cutting direction n (m), less what its spring does not explain.
double cutting_gap(const InsertionView& at, const Path& path, const Insertion& state, double lead, const Vector3& n,
                   double crept) {
  const double apart = n.dot(at.needle.tip().position - at.tissue.position(path.end)) + crept;
  if (state.tip.cut.along == 0 || lead == 0) return apart;
  const double start = lead + n.dot(at.needle.start_tip() - at.tissue.start_position(path.end));
  return apart - shrunk(start, kSettlingSpeed * at.needle.h);
}

// Along the cutting direction of stage 4, to which what holds the tip sideways is orthogonal: in later iterations the
// tip may have turned.
void find_cut(const InsertionView& at, const Path& path, InsertionScratch& scratch, Contacts& contacts) {
  TipState& tip = scratch.next.tip;
  const double cutting_force = at.tissue.interaction(path.end).cutting_force;
  if (path.exited || cutting_force == 0) return;
  const Vector3 n = -scratch.located.tip.cutting;
  const CutSpring spring = cut_spring(at, path.end, tip.cut.creep, scratch.located.tip.ahead);
  Contact cut{.kind = ContactKind::cut, .needle = at.needle_index, .on_needle = at.needle.tip(), .state = &tip.cut};
  cut.foot.point.a = path.end;
  cut.hold = Normal{.n = n,
                    .gap = cutting_gap(at, path, scratch.next, scratch.located.tip.lead, n, spring.crept),
                    .most = cutting_force,
                    .before = tip.cut.along,
                    .compliance = spring.compliance};
  contacts.put(cut);
}

}  // namespace

Across held_across(const InsertionView& at, const HeldPlace& place, const ContactState& state) {
  return {place.tangent, place.apart, place.compliance, tear_limit(at, place, state.across)};
}

double shrunk(double offset, double step) { return std::copysign(std::max(0.0, std::abs(offset) - step), offset); }

bool lies_on_border(const TissueView& tissue, const TipPlace& place) {
  return !place.at_end && place.point.u > 0 && tissue.border_face(place.point.a) && tissue.border_face(place.point.b);
}

void find_surface_contact(const InsertionView& at, InsertionScratch& scratch, Contacts& contacts) {
  assert(scratch.located.obstacle && (scratch.next.path < 0 || scratch.next.phase == Phase::through));
  const Obstacle& obstacle = *scratch.located.obstacle;
  TipState& tip = scratch.next.tip;
  const Interaction& law = at.tissue.interaction(obstacle.material);
  const auto [friction, share] = tip_friction(at, obstacle, law.puncture_force, law.friction_contact);
  Normal hold = against(obstacle, tip, share * law.puncture_force, obstacle_gap(at, obstacle, tip, kSettlingSpeed));
  hold.friction = friction_along(at, obstacle, friction, 0);
  contacts.put(on_obstacle(at, obstacle, ContactKind::surface, hold, tip.contact));
}

void find_border_contact(const InsertionView& at, const Path& path, InsertionScratch& scratch, Contacts& contacts) {
  assert(scratch.located.obstacle);
  const Obstacle& obstacle = *scratch.located.obstacle;
  const Border& border = at.tissue.border(obstacle.material, obstacle.region);
  const double friction = tip_friction(at, obstacle, border.puncture_force, border.friction_contact).friction;
  const double cohesion = border_cohesion(at, path, scratch.next.tip);
  Normal hold = against_border(at, scratch);
  hold.friction = friction_along(at, obstacle, friction, cohesion);
  contacts.put(on_obstacle(at, obstacle, ContactKind::border, hold, scratch.next.tip.contact));
}

void find_path_contacts(const InsertionView& at, const Path& path, InsertionScratch& scratch, Contacts& contacts) {
  assert(scratch.next.path >= 0 && !path.empty());
  ContactState& state = scratch.next.tip.contact;
  find_cut(at, path, scratch, contacts);
  if (const auto& border = scratch.located.obstacle)
    contacts.put(on_obstacle(at, *border, ContactKind::border, against_border(at, scratch), state));
  const TipPlace& place = scratch.located.tip;
  Contact tip{.kind = ContactKind::tip, .needle = at.needle_index, .on_needle = at.needle.tip(), .state = &state};
  tip.foot.point = place.point;
  tip.hold = held_across(at, held_tip(at, place, state.creep), state);
  contacts.put(tip);
  if (!lies_on_border(at.tissue, place)) return;
  tip.foot.point = {place.point.u < 0.5 ? place.point.a : place.point.b, {}, 0};
  const auto behind = [&](const MaterialPoint& p) { return tip_lateral_compliance(at, p, place.supported); };
  find_support(at, tip, ContactKind::tip_support, behind, contacts);
}

}  // namespace acus
