// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/tick/insertion/finding/hub.h"

#include <cmath>

#include "server/engine/tick/insertion/finding/obstacle.h"
#include "server/engine/tick/insertion/spring_memory.h"

namespace acus {

namespace {

NeedleEnd base_of(const InsertionView& at) {
  const CurvePoint now = curve_point(at.needle.model, at.needle.shape, 0);
  return {now, at.needle.start_position(0), at.parameters.hub_diameter / 2 * at.needle.turned(now).norm()};
}

bool is_near(const InsertionView& at, const MaterialPoint& mouth) {
  const NeedleEnd base = base_of(at);
  const double moves = (base.now.position - base.before).norm();
  const double reach = at.parameters.hub_diameter + kContactMargin + 2 * moves;
  return (base.before - at.tissue.start_position(mouth)).norm() < reach;
}

// What the middle of the face is deeper than D - s under a force with which it would be D deep, upright (m): the seat's
// spring. `compliance`: dD/df (m/N).
Spring seat(double s, double D, double compliance, double f) {
  constexpr double kLeast = 1e-3;  // D/2s below which the spring is linear
  if (s == 0) return {};
  const double share = D / (2 * s);
  if (share >= 1) return {s, 0, 0.2 * f * s / share};
  if (share < kLeast) {
    const double slope = 1.5 / std::cbrt(kLeast) - 1;
    return {slope * D, slope * compliance, 0};
  }
  const double third = std::cbrt(share);
  Spring spring{3 * s * third * third - D, (1 / third - 1) * compliance};
  spring.stored = f * D * (0.6 / third - 0.5) - spring.compliance * f * f / 2;
  return spring;
}

// Lets the springs bear what the hub does.
void load(Obstacle& skin, double s) {
  const double f = skin.bears;
  skin.seat = seat(s, skin.dimple.whole(f), skin.dimple.whole_compliance(f), f);
  skin.dimple_before = skin.dimple.depth(f) + skin.seat.depth;
}

// s (m), over a surface with the normal n.
double rim_below(const InsertionView& at, const Vector3& n) {
  const Vector3 axis = curve_point(at.needle.model, at.needle.start, 0).tangent;
  return at.parameters.hub_diameter / 2 * (axis - axis.dot(n) * n).norm();
}

}  // namespace

Obstacle surface_under_hub(const InsertionView& at, const Path& path, const ContactState& state) {
  const TissueView& tissue = at.tissue;
  Obstacle skin;
  skin.material = path.vertices[0];
  skin.region = tissue.region(skin.material);
  skin.at = tissue.surface.closest(tissue.x_start, tissue.start_position(skin.material));
  skin.bears = state.along;
  bear_on_patch(tissue, tissue.surface, -1, at.parameters.hub_diameter, kInfinity, base_of(at), state.creep, skin);
  const double s = rim_below(at, skin.at.normal);
  skin.rise += s;
  load(skin, s);
  return skin;
}

void find_hub(const InsertionView& at, const Path* path, InsertionScratch& scratch) {
  scratch.located.hub.reset();
  if (at.parameters.hub_diameter == 0) return;
  ContactState& state = scratch.next.hub;
  if (path == nullptr || (state.along == 0 && !is_near(at, path->vertices[0]))) {
    state = {};
    return;
  }
  Obstacle& skin = scratch.located.hub.emplace(surface_under_hub(at, *path, state));
  if (!at.tissue.relaxes()) return;
  const RelaxationStep& law = at.tissue.relaxation_of(skin.material);
  creep_to(law, skin.dimple.at_rest(skin.bears), state.creep.along);
  skin.dimple.relax(law, state.creep.along);
  load(skin, rim_below(at, skin.at.normal));
}

void find_hub_contact(const InsertionView& at, InsertionScratch& scratch, Contacts& contacts) {
  if (!scratch.located.hub) return;
  const Obstacle& skin = *scratch.located.hub;
  const NeedleEnd base = base_of(at);
  const double moves = (base.now.position - base.before).norm() + base.turned;
  if (skin.bears == 0 && height_before(skin, base) > kContactMargin + 2 * moves) return;
  ContactState& state = scratch.next.hub;
  const bool crushed = is_crushed(at.tissue.mesh, at.tissue.x_start, skin.patch.points);
  Contact contact =
      on_obstacle(at, skin, ContactKind::hub, base, crushed ? state.along : kInfinity, kSettlingSpeed, state);
  const double friction = at.tissue.interaction(skin.material).friction_contact;
  std::get<Normal>(contact.hold).friction = friction_along(at.tissue, skin, base, friction, 0);
  contacts.put(contact);
}

}  // namespace acus
