// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/tick/insertion/held_place.h"

#include <algorithm>
#include <cmath>

#include "server/engine/tick/insertion/spring_memory.h"
#include "server/engine/tick/insertion/tip_laws.h"

namespace acus {

namespace {

// Share of its strength from which a place has a threshold.
constexpr double kNear = 0.5;
// Time constant with which a force above the strength falls.
constexpr double kFall = 5e-3;  // s

}  // namespace

double beside_compliance(const TissueView& tissue, const MaterialPoint& p, double d, double supported) {
  return tissue.lateral_compliance(p, d) / std::max(supported, kLeastSupported);
}

HeldPlace held_vertex(const InsertionView& at, const MaterialPoint& vertex, const ShaftPoint& point,
                      const Vector3& needle, const Vector3& dimpled, const Creep& creep) {
  const TissueView& tissue = at.tissue;
  const CreptAcross spring = crept_across(tissue, vertex, creep);
  return {vertex, point.tangent, needle - tissue.position(vertex) - dimpled + spring.crept,
          beside_compliance(tissue, vertex, at.needle.model.diameter, point.supported) / spring.stiffening,
          tissue.interaction(vertex).tear_strength * std::max(point.tearing, kLeastSupported)};
}

HeldPlace held_tip(const InsertionView& at, const TipPlace& tip, const Creep& creep) {
  const TissueView& tissue = at.tissue;
  const MaterialPoint& material = tip.point.a;
  const CreptAcross spring = crept_across(tissue, material, creep);
  const double compliance = tip_lateral_compliance(at, material, tip.supported);
  return {material, tip.tangent, at.needle.tip().position - tissue.position(tip.point) + spring.crept,
          compliance / spring.stiffening,
          tissue.interaction(material).tear_strength * std::max(tip.tearing, kLeastSupported)};
}

std::optional<TearLimit> tear_limit(const InsertionView& at, const HeldPlace& place, const Vector3& last) {
  if (std::isinf(place.strength)) return std::nullopt;
  const auto across = [&](const Vector3& vector) {
    const Vector3 borne = borne_by_path(at.tissue, place.material, vector);
    return Vector3(borne - place.tangent.dot(borne) * place.tangent);
  };
  const Vector3 apart = across(place.apart);
  const double before = across(last).norm(), distance = apart.norm();
  if (!(std::max(before, distance / place.compliance) > kNear * place.strength) || distance == 0) return std::nullopt;
  return TearLimit{-apart / distance,
                   place.strength + std::max(0.0, before - place.strength) * std::exp(-at.needle.h / kFall)};
}

Vector3 borne_by_path(const TissueView& tissue, const MaterialPoint& place, const Vector3& vector) {
  const auto face = tissue.border_face(place);
  return face ? Vector3(vector - face->normal.dot(vector) * face->normal) : vector;
}

}  // namespace acus
