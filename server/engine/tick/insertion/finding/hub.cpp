// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/tick/insertion/finding/hub.h"

#include "server/engine/tick/insertion/finding/obstacle.h"
#include "server/engine/tick/insertion/spring_memory.h"

namespace acus {

namespace {

NeedleEnd base_of(const InsertionView& at) {
  return {curve_point(at.needle.model, at.needle.shape, 0), at.needle.start_position(0)};
}

bool is_near(const InsertionView& at, const MaterialPoint& mouth) {
  const NeedleEnd base = base_of(at);
  const double moves = (base.now.position - base.before).norm();
  const double reach = at.parameters.hub_diameter + kContactMargin + 2 * moves;
  return (base.before - at.tissue.start_position(mouth)).norm() < reach;
}

}  // namespace

Obstacle surface_under_hub(const InsertionView& at, const Path& path, const ContactState& state) {
  const TissueView& tissue = at.tissue;
  const double d = at.parameters.hub_diameter;
  Obstacle skin;
  skin.material = path.vertices[0];
  skin.region = tissue.region(skin.material);
  skin.at = tissue.surface.closest(tissue.x_start, tissue.start_position(skin.material));
  skin.bears = state.along;
  bear_on_patch(tissue, tissue.surface, -1, d, kInfinity, base_of(at), state.creep, skin);
  const Vector3& n = skin.at.normal;
  const Vector3 axis = curve_point(at.needle.model, at.needle.start, 0).tangent;
  skin.rise += d / 2 * (axis - axis.dot(n) * n).norm();
  skin.dimple_before = skin.dimple.depth(skin.bears);
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
  const RelaxationStep& law = at.tissue.relaxation_of(skin.material);
  creep_to(law, skin.dimple.at_rest(skin.bears), state.creep.along);
  skin.dimple.relax(law, state.creep.along);
  skin.dimple_before = skin.dimple.depth(skin.bears);
}

void find_hub_contact(const InsertionView& at, InsertionScratch& scratch, Contacts& contacts) {
  if (!scratch.located.hub) return;
  const Obstacle& skin = *scratch.located.hub;
  const NeedleEnd base = base_of(at);
  ContactState& state = scratch.next.hub;
  const bool crushed = is_crushed(at.tissue.mesh, at.tissue.x_start, skin.patch.points);
  Contact contact =
      on_obstacle(at, skin, ContactKind::hub, base, crushed ? state.along : kInfinity, kSettlingSpeed, state);
  const double friction = at.tissue.interaction(skin.material).friction_contact;
  std::get<Normal>(contact.hold).friction = friction_along(at.tissue, skin, base, friction, 0);
  contacts.put(contact);
}

}  // namespace acus
