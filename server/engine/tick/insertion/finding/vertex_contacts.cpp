// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/tick/insertion/finding/vertex_contacts.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>
#include <optional>

#include "server/engine/laws/friction_cone.h"
#include "server/engine/math/rotation.h"
#include "server/engine/tick/insertion/finding/obstacle.h"
#include "server/engine/tick/insertion/finding/tip_contacts.h"
#include "server/engine/tick/insertion/held_place.h"

namespace acus {

namespace {

// Least owned length (in spacings) in the compliance of friction.
constexpr double kLeastOwned = 0.1;
// Stretch of a spring, as a share of its owned length, from which it is far strained.
constexpr double kFarStrained = 0.25;

// lambda_n (N) of a vertex with the owned length (m); axial: m²/N.
double strained_force(const VertexState& state, double owned, double axial) {
  const double force = state.traction * owned, most = std::abs(state.contact.along);
  const bool far = axial * std::abs(state.traction) > kFarStrained * owned;
  return far && !state.contact.sliding ? std::clamp(force, -most, most) : force;
}

// None where it can bear nothing.
std::optional<Along> friction_of(const InsertionView& at, const Path& path, const VertexState& state,
                                 const ShaftPoint& point, const CurvePoint& on_needle) {
  const TissueView& tissue = at.tissue;
  const NeedleView& needle = at.needle;
  const MaterialPoint& material = path.vertices[point.vertex];
  const Interaction& law = tissue.interaction(material);
  const double normal = point.owned * std::numbers::pi * needle.model.diameter * *law.pressure;
  Along hold{.tangent = point.tangent};
  hold.friction = {.law = {.threshold = normal * (state.contact.sliding ? law.friction_dynamic : law.friction_static),
                           .viscosity = point.owned * law.friction_viscous / needle.h,
                           .thinning = law.friction_thinning_speed.value_or(kInfinity) * needle.h,
                           .exponent = law.friction_exponent},
                   .back = law.friction_back};
  if (normal * law.friction_static == 0 && hold.friction.law.viscosity == 0) return std::nullopt;
  const Vector3 before = needle.start_position(point.s) - tissue.start_position(material);
  const double axial = tissue.axial_compliance(material, needle.model.diameter);
  hold.compliance =
      axial / std::max(point.owned, kLeastOwned * path.spacing) / tissue.relaxation_of(material).stiffening;
  hold.slip = point.tangent.dot(on_needle.position - tissue.position(material) - before) -
              hold.compliance * strained_force(state, point.owned, axial) + point.crept;
  const double share = at.parameters.torsional_friction;
  if (share == 0) return hold;
  hold.radius = share * needle.model.diameter / 2;
  hold.turned =
      hold.radius * point.tangent.dot(needle.turned(on_needle) -
                                      material_rotation(tissue.mesh, tissue.x_start, tissue.x, material.tetrahedron));
  return hold;
}

}  // namespace

void find_vertex_contacts(const InsertionView& at, const Path& path, InsertionScratch& scratch, const ShaftPoint& point,
                          Contacts& contacts) {
  assert(point.vertex >= 0 && point.vertex < static_cast<int>(path.vertices.size()) && point.owned >= 0);
  const TissueView& tissue = at.tissue;
  VertexState& state = scratch.next.vertices[point.vertex];
  const MaterialPoint& material = path.vertices[point.vertex];
  const Vector3 dimpled = beside_dimple(at, path, scratch, material);
  Contact contact{.kind = ContactKind::vertex,
                  .needle = at.needle_index,
                  .on_needle = curve_point(at.needle.model, at.needle.shape, point.s),
                  .state = &state.contact};
  contact.foot.point.a = material;
  const HeldPlace place = held_vertex(at, material, point, contact.on_needle.position, dimpled, state.contact.creep);
  contact.hold = held_across(at, place, state.contact);
  contacts.put(contact);
  // A tip nearer to this vertex than to the next has the support itself.
  const TipPlace& tip = scratch.located.tip;
  const bool at_tip = &point == &scratch.located.shaft.back() && tip.point.u < 0.5 && lies_on_border(tissue, tip);
  const auto beside = [&](const MaterialPoint& p) {
    return beside_compliance(tissue, p, at.needle.model.diameter, point.supported);
  };
  if (!at_tip) find_support(at, contact, ContactKind::shaft_support, beside, contacts, dimpled);
  const auto friction = friction_of(at, path, state, point, contact.on_needle);
  if (!friction) return;
  contact.hold = *friction;
  contacts.put(contact);
}

}  // namespace acus
