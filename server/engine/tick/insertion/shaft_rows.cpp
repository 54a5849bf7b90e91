// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/tick/insertion/shaft_rows.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

#include "server/engine/laws/friction_cone.h"
#include "server/engine/math/rotation.h"
#include "server/engine/tick/insertion/held_place.h"
#include "server/engine/tick/insertion/obstacle.h"
#include "server/engine/tick/insertion/tip_rows.h"

namespace acus {

namespace {

// Least owned length (in spacings) in the compliance of a friction row.
constexpr double kLeastOwned = 0.1;
// Stretch of a spring, as a share of its owned length, from which it is far strained.
constexpr double kFarStrained = 0.25;

// lambda_n (N) of a vertex with the owned length (m); axial: m²/N.
double strained_force(const VertexState& state, double owned, double axial) {
  const double force = state.traction * owned, most = std::abs(state.friction);
  const bool far = axial * std::abs(state.traction) > kFarStrained * owned;
  return far && !state.sliding ? std::clamp(force, -most, most) : force;
}

// What a friction row's spring has crept in the last tick (m); `axial_stretch`: of the traction, at rest.
double crept_along(const RelaxationStep& law, double axial_stretch, const PointMemory& memory) {
  return (axial_stretch + law.given.dot(memory.along)) / law.stiffening - memory.stretch;
}

// `row` stands at the vertex along the path's tangent.
bool add_friction(const InsertionView& at, const Path& path, const VertexState& state, const PointMemory* memory,
                  const ShaftPoint& point, Row& row, Rows& rows) {
  const TissueView& tissue = at.tissue;
  const NeedleView& needle = at.needle;
  const MaterialPoint& material = row.in_tissue.a;
  const Interaction& law = tissue.interaction(material);
  const double normal = point.owned * std::numbers::pi * needle.model.diameter * *law.pressure;
  const FrictionCone friction{
      .law = {.threshold = normal * (state.sliding ? law.friction_dynamic : law.friction_static),
              .viscosity = point.owned * law.friction_viscous / needle.h,
              .thinning = law.friction_thinning_speed.value_or(kInfinity) * needle.h,
              .exponent = law.friction_exponent},
      .back = law.friction_back};
  if (normal * law.friction_static == 0 && friction.law.viscosity == 0) return true;
  const Vector3 before = needle.start_position(point.s) - tissue.start_position(material);
  const double axial = tissue.axial_compliance(material, needle.model.diameter);
  row.role = RowRole::friction;
  const double stiffening = memory != nullptr ? tissue.relaxation_of(material).stiffening : 1;
  row.compliance = axial / std::max(point.owned, kLeastOwned * path.spacing) / stiffening;
  row.gap = row.n.dot(row.on_needle.position - tissue.position(material) - before) -
            row.compliance * strained_force(state, point.owned, axial);
  if (memory != nullptr) row.gap += crept_along(tissue.relaxation_of(material), axial * state.traction, *memory);
  const double share = at.parameters.torsional_friction;
  if (share == 0 && friction.back == 1 && friction.law.is_linear())
    return rows.add(row, {LawKind::friction, friction.law.threshold, friction.law.viscosity}, state.friction);
  if (share == 0) return rows.add_cone(row, friction, state.friction);
  Row about = row;
  about.role = RowRole::torsion;
  about.compliance = 0;
  about.radius = share * needle.model.diameter / 2;
  about.gap = about.radius * row.n.dot(needle.turned(row.on_needle) -
                                       material_rotation(tissue.mesh, tissue.x_start, tissue.x, material.tetrahedron));
  return rows.add_cone(row, about, friction, {state.friction, state.torsion});
}

}  // namespace

bool add_shaft_rows(const InsertionView& at, const Path& path, const InsertionScratch& scratch, const ShaftPoint& point,
                    Rows& rows) {
  assert(point.vertex >= 0 && point.vertex < static_cast<int>(path.vertices.size()) && point.owned >= 0);
  const TissueView& tissue = at.tissue;
  const VertexState& state = scratch.next.vertices[point.vertex];
  const MaterialPoint& material = path.vertices[point.vertex];
  const CurvePoint on_needle = curve_point(at.needle.model, at.needle.shape, point.s);
  const PointMemory* memory = tissue.relaxes() ? &scratch.next.memory->vertices[point.vertex] : nullptr;
  const Vector3 dimpled = beside_dimple(at, path, scratch, material);
  Row row{at.needle_index, RowRole::lateral, point.vertex, on_needle, {material, {}, 0}, Vector3::Zero(), 0};
  const auto beside = [&](const MaterialPoint& p) {
    return beside_compliance(tissue, p, at.needle.model.diameter, point.supported);
  };
  const HeldPlace place = held_vertex(at, material, point, on_needle.position, dimpled, memory);
  bool all = add_across(at, row, place, state.lateral, rows);
  // A tip nearer to this vertex than to the next has the support row itself.
  const TipPlace& tip = scratch.located.tip;
  const bool at_tip = &point == &scratch.located.shaft.back() && tip.point.u < 0.5 && lies_on_border(tissue, tip);
  if (!at_tip) all = add_support(at, row, beside, rows, dimpled) && all;
  row.n = point.tangent;
  return add_friction(at, path, state, memory, point, row, rows) && all;
}

}  // namespace acus
