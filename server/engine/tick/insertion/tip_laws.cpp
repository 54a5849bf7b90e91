// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/tick/insertion/tip_laws.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace acus {

namespace {

// Of the angle of a tip's face, of the standard.
constexpr double kFaceTolerance = 2 * std::numbers::pi / 180;  // rad

}  // namespace

CutSpring cut_spring(const InsertionView& at, const MaterialPoint& end, const Creep& creep, const BorderAhead& border) {
  const double cutting_force = at.tissue.interaction(end).cutting_force;
  const RelaxationStep& law = at.tissue.relaxation_of(end);
  const CutSpring free{at.tissue.tip_compliance(end, at.parameters.outer_diameter, cutting_force) / law.stiffening,
                       law.given.dot(creep.along) / law.stiffening};
  if (cutting_force == 0 || std::isinf(border.distance)) return free;
  const double lead = free.lead(cutting_force), to_go = std::max(0.0, border.distance + border.dimple);
  const double near =
      lead > border.dimple ? std::min(lead, border.dimple + to_go) : std::max(lead, border.dimple - to_go / 2);
  const double crept = free.crept > 0 ? free.crept * near / lead : 0;
  return {(near - crept) / cutting_force, crept};
}

double tip_lateral_compliance(const InsertionView& at, const MaterialPoint& material, double supported) {
  const double d = at.needle.model.diameter;
  const double end = 1 / at.tissue.end_compliance(material, d);
  return 1 / (end + supported / at.tissue.lateral_compliance(material, d));
}

double end_length(const InsertionView& at, const MaterialPoint& material) {
  const double d = at.needle.model.diameter, end = at.tissue.end_compliance(material, d);
  return end > 0 ? at.tissue.lateral_compliance(material, d) / end : 0;
}

TipFriction tip_friction(const Needle& needle, const Vector3& along, const Vector3& normal, double friction) {
  const std::optional<double> face = face_angle(needle);
  if (!face) return {friction, 1};
  const double inwards = std::min(-along.dot(normal), 1.0);  // cos theta
  const double flat = std::sin(std::max(0.0, *face - kFaceTolerance)), sticks = std::sin(*face + kFaceTolerance);
  const double share = std::clamp((inwards - flat) / (sticks - flat), 0.0, 1.0);
  const double most = std::max(friction, 1 / std::tan(*face));
  return {friction + share * (most - friction), 1 + share * (inwards - 1)};
}

TipFriction tip_friction(const InsertionView& at, const Obstacle& obstacle, double puncture_force, double friction) {
  if (std::isinf(puncture_force)) return {friction, 1};
  const NeedleView& needle = at.needle;
  const Vector3 along = curve_point(needle.model, needle.start, needle.model.length).tangent;
  return tip_friction(at.parameters, along, obstacle.at.normal, friction);
}

double force_along_needle(const InsertionView& at, const Obstacle& obstacle, double puncture_force, double contact) {
  return contact / tip_friction(at, obstacle, puncture_force, 0).puncture_share;
}

}  // namespace acus
