// SPDX-License-Identifier: GPL-3.0-or-later
// What the laws see of a tick: needle and tissue at its start and at the current iterate, read only.
#pragma once

#include <optional>
#include <span>

#include "server/engine/models/element/relaxation.h"
#include "server/engine/models/geometry/surface.h"
#include "server/engine/models/needle/needle.h"
#include "server/engine/models/unresolved/dimple.h"
#include "server/engine/models/unresolved/groove.h"
#include "server/engine/scene/scene.h"
#include "server/engine/state/borders.h"

namespace acus {

struct BorderFace {
  Vector3 normal;  // unit, world, towards the side that was asked from
  int beyond;      // the tetrahedron on the other side
};

struct TissueView {
  const TetrahedralMesh& mesh;
  const Surface& surface;
  const Borders& borders;
  std::span<const Region> tissue_regions;
  std::span<const Interaction> interactions;     // per region, pressure filled in
  std::span<const double> element_sizes;         // per tetrahedron (m)
  std::span<const int> regions;                  // per tetrahedron
  const Matrix3X& x_start;                       // at the start of the tick (m)
  const Matrix3X& x;                             // x_k
  bool local_compliance = true;                  // tissue.local_compliance: all
  double surface_moved = 0;                      // m, State::surface_moved
  std::span<const RelaxationStep> relaxation{};  // per region, none where no tissue relaxes
  std::span<const int> free_index{};             // per node, below 0 if fixed; none: all are free

  int region(const MaterialPoint& p) const { return regions[p.tetrahedron]; }
  // Of a place, how far fixed nodes carry it: from 0 to 1.
  double held_share(const MaterialPoint& p) const;
  Moduli moduli(const MaterialPoint& p) const { return tissue_regions[region(p)].material; }
  const Interaction& interaction(const MaterialPoint& p) const { return interactions[region(p)]; }
  bool relaxes() const { return !relaxation.empty(); }
  const RelaxationStep& relaxation_of(const MaterialPoint& p) const {
    static const RelaxationStep kElastic;
    return relaxes() ? relaxation[region(p)] : kElastic;
  }
  // Of both sides of a border, each with its share of the stiffness; branches of different times have a mean one.
  // `behind`: as in dimple_spring().
  RelaxationStep relaxation_of(const MaterialPoint& p, int behind) const;
  // What a tip at a point meets at the border into another region.
  const Border& border(const MaterialPoint& from, int into) const { return borders.at(region(from), into); }
  // A face that the point lies on and behind which a region begins that holds tips.
  std::optional<BorderFace> border_face(const MaterialPoint& p) const;
  // Of the tissue beside a shaft of diameter d (m): m²/N, see foundation_compliance().
  double lateral_compliance(const MaterialPoint& p, double d) const;
  // Of the tissue around its end, across it: m/N, see end_compliance().
  double end_compliance(const MaterialPoint& p, double d) const;
  // Along the same shaft, m²/N; see local_compliance.h. Zero if the scene leaves it out.
  double axial_compliance(const MaterialPoint& p, double d) const;
  // Of the skin where that shaft goes through it or, with a tip inside, in; m, likewise. q in N/m, L and length in m.
  double surface_displacement(const MaterialPoint& p, double d, double q, double L) const;
  double mouth_displacement(const MaterialPoint& p, double d, double q, double length) const;
  // Of the disc of surface over which a tip of diameter d (m) spreads its contact: the force f_w (N) for which
  // it is laid out where the tip bears f (N) and is s (m) below the point, its radius (m) for that, and what the mesh
  // lacks of the dimple's depth; see dimple.h. `behind`: the region behind a border, -1 on the surface of the whole.
  double disc_load(const MaterialPoint& p, double d, double f, double s, int behind = -1) const;
  double contact_radius(const MaterialPoint& p, double d, double f_w, int behind = -1) const;
  DimpleSpring dimple_spring(const MaterialPoint& p, double d, double f_w, int behind = -1) const;
  // What the mesh lacks of the groove under `length` (m) of a shaft of diameter d (m) that lies on the surface; see
  // groove.h.
  GrooveSpring groove_spring(const MaterialPoint& p, double d, double length) const;
  // Of the tissue ahead of a tip inside that bears f (N) at most: m/N, likewise.
  double tip_compliance(const MaterialPoint& p, double d, double f) const;
  // Of the loads whose compliance that is: of a shaft of diameter d (m), and of its tip inside.
  LoadRadii shaft_radii(const MaterialPoint& p, double d) const;
  LoadRadii tip_radii(const MaterialPoint& p, double d, double f) const;
  // What a tip presses into at a point, and the force at which it goes in (N).
  Indented indented(const MaterialPoint& p, int behind) const;
  double puncture_force(const MaterialPoint& p, int behind) const;
  Vector3 position(const MaterialPoint& p) const { return material_position(mesh, x, p); }
  Vector3 position(const TissuePoint& p) const { return tissue_position(mesh, x, p); }
  Vector3 start_position(const MaterialPoint& p) const { return material_position(mesh, x_start, p); }
};

struct NeedleView {
  const NeedleModel& model;
  const NeedleShape& start;  // at the start of the tick
  const NeedleShape& shape;  // q_k
  double h;                  // s

  CurvePoint tip() const { return curve_point(model, shape, model.length); }
  Vector3 start_position(double s) const { return curve_point(model, start, s).position; }
  Vector3 start_tip() const { return start_position(model.length); }
  // Rotation of the needle at a point of its curve since the start of the tick (rad, world).
  Vector3 turned(const CurvePoint& point) const;
};

// The arc length near `guess` at which the needle's curve passes through the plane at p across t (m).
double project_on_curve(const NeedleView& needle, const Vector3& p, const Vector3& t, double guess);

}  // namespace acus
