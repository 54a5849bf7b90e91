// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/tick/views.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "server/engine/math/rotation.h"
#include "server/engine/models/unresolved/local_compliance.h"

namespace acus {

namespace {

// Times 1/E (m²/N): next to the compliance of a mesh it is nothing, and two points of a path at one place can be held.
constexpr double kLeastGive = 1e-4;
// What the end of a needle bears across its way beyond what its length does, as a length (in diameters).
constexpr double kEndBearing = 1.5;

}  // namespace

std::optional<BorderFace> TissueView::border_face(const MaterialPoint& p) const {
  constexpr double kOnFace = 1e-6;
  if (!borders.any()) return std::nullopt;
  for (int k = 0; k < 4; ++k) {
    const int beyond = p.weights[k] < kOnFace ? mesh.neighbours[p.tetrahedron][k] : -1;
    if (beyond < 0 || regions[beyond] == region(p) || !border(p, regions[beyond]).holds) continue;
    return BorderFace{shape_gradients(mesh, x, p.tetrahedron).col(k).stableNormalized(), beyond};
  }
  return std::nullopt;
}

double TissueView::lateral_compliance(const MaterialPoint& p, double d) const {
  const std::optional<double>& given = tissue_regions[region(p)].interaction.foundation_stiffness;
  double compliance = 0;
  if (given)
    compliance = 1 / *given;
  else if (local_compliance)
    compliance = foundation_compliance(moduli(p), element_sizes[p.tetrahedron], d);
  return std::max(compliance, kLeastGive / moduli(p).young);
}

double TissueView::end_compliance(const MaterialPoint& p, double d) const {
  const std::optional<double>& given = tissue_regions[region(p)].interaction.foundation_stiffness;
  double compliance = 0;
  if (given)
    compliance = 1 / (*given * kEndBearing * d);
  else if (local_compliance)
    compliance = acus::end_compliance(moduli(p), element_sizes[p.tetrahedron], d);
  return std::max(compliance, kLeastGive / (moduli(p).young * kEndBearing * d));
}

double TissueView::axial_compliance(const MaterialPoint& p, double d) const {
  if (!local_compliance) return 0;
  return acus::axial_compliance(moduli(p), element_sizes[p.tetrahedron], d);
}

double TissueView::surface_displacement(const MaterialPoint& p, double d, double q, double L) const {
  if (!local_compliance) return 0;
  return acus::surface_displacement(moduli(p), element_sizes[p.tetrahedron], d, q, L);
}

double TissueView::mouth_displacement(const MaterialPoint& p, double d, double q, double length) const {
  if (!local_compliance) return 0;
  return acus::mouth_displacement(moduli(p), element_sizes[p.tetrahedron], d, q, length);
}

double TissueView::held_share(const MaterialPoint& p) const {
  if (free_index.empty()) return 0;
  double held = 0;
  for (int i = 0; i < 4; ++i)
    if (free_index[mesh.tetrahedra[p.tetrahedron][i]] < 0) held += p.weights[i];
  return std::clamp(held / p.weights.sum(), 0.0, 1.0);
}

RelaxationStep TissueView::relaxation_of(const MaterialPoint& p, int behind) const {
  const RelaxationStep& here = relaxation_of(p);
  if (behind < 0 || !relaxes()) return here;
  const RelaxationStep& beyond = relaxation[behind];
  const double share = indented(p, -1).stiffness / indented(p, behind).stiffness;
  RelaxationStep both;
  both.stiffening = share * here.stiffening + (1 - share) * beyond.stiffening;
  both.given = share * here.given + (1 - share) * beyond.given;
  for (int i = 0; i < both.given.size(); ++i)
    both.taken[i] =
        both.given[i] > 0
            ? (share * here.given[i] * here.taken[i] + (1 - share) * beyond.given[i] * beyond.taken[i]) / both.given[i]
            : 0;
  return both;
}

Indented TissueView::indented(const MaterialPoint& p, int behind) const {
  const auto side = [&](int region) {
    return Indented(tissue_regions[region].material, interactions[region].deep_indentation);
  };
  Indented tissue = side(region(p));
  if (behind >= 0) tissue += side(behind);
  return tissue;
}

double TissueView::puncture_force(const MaterialPoint& p, int behind) const {
  return behind < 0 ? interaction(p).puncture_force : border(p, behind).puncture_force;
}

double TissueView::disc_load(const MaterialPoint& p, double d, double f, double s, int behind) const {
  return acus::disc_load(indented(p, behind), element_sizes[p.tetrahedron], d, puncture_force(p, behind), f, s);
}

double TissueView::contact_radius(const MaterialPoint& p, double d, double f_w, int behind) const {
  return acus::contact_radius(indented(p, behind), d, f_w);
}

DimpleSpring TissueView::dimple_spring(const MaterialPoint& p, double d, double f_w, int behind) const {
  return {indented(p, behind), element_sizes[p.tetrahedron], d, f_w};
}

GrooveSpring TissueView::groove_spring(const MaterialPoint& p, double d, double length) const {
  return {moduli(p), local_compliance ? element_sizes[p.tetrahedron] : 0, d, length,
          local_compliance ? held_share(p) : 0};
}

double TissueView::tip_compliance(const MaterialPoint& p, double d, double f) const {
  if (!local_compliance) return 0;
  return acus::tip_compliance(moduli(p), element_sizes[p.tetrahedron], d, f);
}

LoadRadii TissueView::shaft_radii(const MaterialPoint& p, double d) const {
  return acus::shaft_radii(element_sizes[p.tetrahedron], d);
}

LoadRadii TissueView::tip_radii(const MaterialPoint& p, double d, double f) const {
  return acus::tip_radii(moduli(p), element_sizes[p.tetrahedron], d, f);
}

Vector3 NeedleView::turned(const CurvePoint& point) const {
  const auto node = [&](int i) {
    return rotation_log(Quaternion(Matrix3(shape.frames[i] * start.frames[i].transpose())));
  };
  return (1 - point.u) * node(point.beam) + point.u * node(point.beam + 1);
}

double project_on_curve(const NeedleView& needle, const Vector3& p, const Vector3& t, double guess) {
  assert(!(std::abs(t.squaredNorm() - 1) > 1e-6));
  constexpr int kIterations = 8;
  constexpr double kStop = 1e-13;  // m
  double s = guess;
  for (int i = 0; i < kIterations; ++i) {
    const CurvePoint c = curve_point(needle.model, needle.shape, s);
    const double slope = std::max(c.tangent.dot(t), 0.1);  // the needle runs along t, not across it
    const double step = std::clamp(t.dot(p - c.position) / slope, -needle.model.length, needle.model.length);
    s += step;
    if (std::abs(step) < kStop) break;
  }
  return s;
}

}  // namespace acus
