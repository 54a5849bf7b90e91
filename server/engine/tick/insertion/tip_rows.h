// SPDX-License-Identifier: GPL-3.0-or-later
// The rows of the tip: contact with a surface or an inner border, cutting, and the hold of its path.
//
// A tip that cuts has its cutting row along -c, c the cutting direction, and two lateral rows across c. c is fixed
// in the tip's frame, so the spin of the base turns it through the needle's own torsional compliance, and torsional
// friction makes it lag. A tip that is pulled, or pushed again through an old path, is held to the path instead, whatever
// its bevel.
//
// A border of a region that holds the tip (borders.h) is a surface inside. Ahead of a cutting tip it adds a contact row,
// capped by f_p. A tip that rests against it, or that the base's motion takes there in this tick, has two rows of
// friction along the border with the cohesion f_c (laws.h) instead of its cutting and lateral rows: it slides, and cuts
// as it slides, once the force along the border is more than f_c + mu times the contact force; back along its path there
// is nothing left to cut. Kept to its cutting direction, a tip that grazes the border would be wedged in.
//
// Across its way the tip is held by the tissue around its end and beside its last stretch (location.h, tip_compliance.h), on its
// position in the path: at the end as behind it, so that neither way makes a jump.
//
// Springs stand in series (rows.h, local_compliance.h): e in the contact row of a surface and in the cutting row. The tip
// stands e lambda beyond the mesh's surface, or beyond the path's end: tissue which is really at the tip stands behind it
// in the mesh. A tip that cuts leaves its path's end e f_c behind along the cutting direction, so that the force stays at
// f_c as the end moves on; towards a border that holds it e falls to nothing (tip_compliance.h).
//
// The friction of a sharp tip: tip_friction.h.
//
// A law that cannot bear any force has no row. All functions return false if a row did not fit.
#pragma once

#include "server/engine/laws/rows.h"
#include "server/engine/tick/insertion/insertion.h"

namespace acus {

// Outside, or through, against the surface in located.obstacle.
bool add_surface_rows(const InsertionView& at, const InsertionWork& work, Rows& rows);
// Inside, against the border in located.obstacle.
bool add_border_rows(const InsertionView& at, const Path& path, const InsertionWork& work, Rows& rows);
// Inside its path.
bool add_path_rows(const InsertionView& at, const Path& path, const InsertionWork& work, Rows& rows);

// A border that the path lies on keeps the needle out of the region behind it, however soft the tissue on this side is: a
// unilateral row at the point of `row`, with the compliance (m/N) that is asked for of a point behind the border.
template <class ComplianceAt>
bool add_support(const InsertionView& at, Row row, ComplianceAt compliance_at, Rows& rows) {
  const TissueView& tissue = at.tissue;
  const auto face = tissue.border_face(row.in_tissue.a);
  if (!face) return true;
  row.n = face->normal;
  row.gap = row.n.dot(row.on_needle.position - tissue.position(row.in_tissue.a));
  row.compliance = compliance_at(MaterialPoint{face->beyond, {}});
  return rows.add(row, {LawKind::unilateral, kInfinity}, 0);
}

// Distance of the tip from the path's end against the cutting direction n (m), less what gives way before it.
double cutting_gap(const InsertionView& at, const Path& path, const TipMemory& tip, const Vector3& n, double compliance);

}  // namespace acus
