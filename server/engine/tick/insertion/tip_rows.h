// SPDX-License-Identifier: GPL-3.0-or-later
// The rows of the tip: contact with a surface or a border, cutting, and lateral support by its path.
//
// A tip that cuts has its cutting row along -c, c the cutting direction, fixed in the tip's frame, and two rows across
// c. A tip that is pulled, or pushed through an old path, has rows across the path instead.
//
// Ahead of a cutting tip, a border that holds tips (state/borders.h) adds a contact row for what it bears beyond the
// cut: both together are capped by f_p. A tip on the border, or one that the base moves there in this tick, has two
// rows of friction along the border with the cohesion f_c (laws.h) instead of cutting and lateral rows: it cuts as it
// slides. Back along its path the cohesion is 0.
//
// The tip's support is that of its end and its supported length (owned_lengths.h, tip_laws.h), at the end of the path
// as behind it.
//
// Springs in series (rows.h) are in the contact row (models/unresolved/dimple.h) and in the cutting row, there with the
// compliance e (tip_laws.h): the tip is beyond the mesh's surface, or its path's end, by the springs' stretch.
//
// A law that cannot bear any force has no row. All functions return false if a row did not fit.
#pragma once

#include "server/engine/laws/rows.h"
#include "server/engine/tick/insertion/held_place.h"
#include "server/engine/tick/insertion/insertion.h"

namespace acus {

// Outside, or through, against the surface in located.obstacle.
bool add_surface_rows(const InsertionView& at, const InsertionScratch& scratch, Rows& rows);
// Inside, against the border in located.obstacle.
bool add_border_rows(const InsertionView& at, const Path& path, const InsertionScratch& scratch, Rows& rows);
// Inside its path.
bool add_path_rows(const InsertionView& at, const Path& path, const InsertionScratch& scratch, Rows& rows);

// Two rows across a path that hold the needle to a place of it, where `row` stands. `last`: their force in the last
// tick (N). Near the path's strength one of them is a row of friction (tearing.h).
bool add_across(const InsertionView& at, Row row, const HeldPlace& place, const Vector3& last, Rows& rows);

// A border that the path lies on keeps the needle out of the region behind it, however soft the tissue on this side is,
// by a unilateral row at the point of `row`. compliance_at: the compliance (m/N) at a point behind the border; `moved`
// (m): beside_dimple().
template <class ComplianceAt>
bool add_support(const InsertionView& at, Row row, ComplianceAt compliance_at, Rows& rows,
                 const Vector3& moved = Vector3::Zero()) {
  const TissueView& tissue = at.tissue;
  const auto face = tissue.border_face(row.in_tissue.a);
  if (!face) return true;
  row.n = face->normal;
  row.gap = row.n.dot(row.on_needle.position - tissue.position(row.in_tissue.a) - moved);
  row.compliance = compliance_at(MaterialPoint{face->beyond, {}});
  return rows.add(row, {LawKind::unilateral, kInfinity}, 0);
}

// Whether a tip back inside is held out of a region by a border that its path lies on, ahead of it and behind: then it
// has the support row of the nearer of the two vertices.
bool lies_on_border(const TissueView& tissue, const TipPlace& place);

// Speed at which the offset of a loaded contact is closed that a change of compliance from element to element leaves.
// Forces change slowly with it.
inline constexpr double kSettlingSpeed = 5e-3;  // m/s
// An offset (m) made smaller by `step` (m).
double shrunk(double offset, double step);

// Distance of the tip from the path's end against the cutting direction n (m), less the spring's part.
double cutting_gap(const InsertionView& at, const Path& path, const TipState& tip, const Vector3& n, double compliance);

}  // namespace acus
