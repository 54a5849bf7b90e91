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

// Against the border in scratch.located.obstacle, of which the tip's cut bears a part.
Contact on_border(const InsertionView& at, InsertionScratch& scratch) {
  const Obstacle& obstacle = *scratch.located.obstacle;
  const Border& border = at.tissue.border(obstacle.material, obstacle.region);
  const double share = tip_friction(at, obstacle, border.puncture_force, border.friction_contact).puncture_share;
  ContactState& state = scratch.next.tip.contact;
  const double by_cut = obstacle.bears - state.along;
  return on_obstacle(at, obstacle, ContactKind::border, tip_of(at),
                     std::max(0.0, share * border.puncture_force - by_cut), kRecoverySpeed, state);
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

bool lies_on_border(const TissueView& tissue, const TipPlace& place) {
  return !place.at_end && place.point.u > 0 && tissue.border_face(place.point.a) && tissue.border_face(place.point.b);
}

void find_surface_contact(const InsertionView& at, InsertionScratch& scratch, Contacts& contacts) {
  assert(scratch.located.obstacle && (scratch.next.path < 0 || scratch.next.phase == Phase::through));
  const Obstacle& obstacle = *scratch.located.obstacle;
  const Interaction& law = at.tissue.interaction(obstacle.material);
  const auto [friction, share] = tip_friction(at, obstacle, law.puncture_force, law.friction_contact);
  const NeedleEnd tip = tip_of(at);
  ContactState& state = scratch.next.tip.contact;
  const bool crushed = is_crushed(at.tissue.mesh, at.tissue.x_start, obstacle.patch.points);
  const double most = obstacle.yields ? share * law.puncture_force : crushed ? state.along : kInfinity;
  Contact contact = on_obstacle(at, obstacle, ContactKind::surface, tip, most, kSettlingSpeed, state);
  std::get<Normal>(contact.hold).friction = friction_along(at.tissue, obstacle, tip, friction, 0);
  contacts.put(contact);
}

void find_border_contact(const InsertionView& at, const Path& path, InsertionScratch& scratch, Contacts& contacts) {
  assert(scratch.located.obstacle);
  const Obstacle& obstacle = *scratch.located.obstacle;
  const Border& border = at.tissue.border(obstacle.material, obstacle.region);
  const double friction = tip_friction(at, obstacle, border.puncture_force, border.friction_contact).friction;
  const double cohesion = border_cohesion(at, path, scratch.next.tip);
  Contact contact = on_border(at, scratch);
  std::get<Normal>(contact.hold).friction = friction_along(at.tissue, obstacle, tip_of(at), friction, cohesion);
  contacts.put(contact);
}

void find_path_contacts(const InsertionView& at, const Path& path, InsertionScratch& scratch, Contacts& contacts) {
  assert(scratch.next.path >= 0 && !path.empty());
  ContactState& state = scratch.next.tip.contact;
  find_cut(at, path, scratch, contacts);
  if (scratch.located.obstacle) contacts.put(on_border(at, scratch));
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
