// SPDX-License-Identifier: GPL-3.0-or-later
// The contacts of the tip: with a surface or a border, cutting, and lateral support by its path.
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
// A law that cannot bear any force has no contact.
#pragma once

#include "server/engine/tick/contact/contact.h"
#include "server/engine/tick/insertion/held_place.h"
#include "server/engine/tick/insertion/insertion.h"
#include "server/engine/tick/insertion/spring_memory.h"

namespace acus {

// Outside, or through, with the surface in located.obstacle.
void find_surface_contact(const InsertionView& at, InsertionScratch& scratch, Contacts& contacts);
// Inside, on the border in located.obstacle.
void find_border_contact(const InsertionView& at, const Path& path, InsertionScratch& scratch, Contacts& contacts);
// Inside its path.
void find_path_contacts(const InsertionView& at, const Path& path, InsertionScratch& scratch, Contacts& contacts);

// What holds the needle across a path at `place`, of a tip or vertex whose state is that of `contact`.
Across held_across(const InsertionView& at, const HeldPlace& place, const ContactState& state);

// A border that the path lies on keeps the needle out of the region behind it, however soft the tissue on this side is,
// by a unilateral contact at the place of `beside`. compliance_at: the compliance (m/N) at a point behind the border;
// `moved` (m): beside_dimple().
template <class ComplianceAt>
void find_support(const InsertionView& at, const Contact& beside, ContactKind kind, ComplianceAt compliance_at,
                  Contacts& contacts, const Vector3& moved = Vector3::Zero()) {
  const TissueView& tissue = at.tissue;
  const auto face = tissue.border_face(beside.foot.point.a);
  if (!face) return;
  const MaterialPoint beyond{face->beyond, {}};
  const CreptAcross spring = crept_across(tissue, beyond, beside.state->creep);
  const Vector3 apart = beside.on_needle.position - tissue.position(beside.foot.point.a) - moved + spring.crept;
  Contact support = beside;
  support.kind = kind;
  support.hold = Normal{
      .n = face->normal, .gap = face->normal.dot(apart), .compliance = compliance_at(beyond) / spring.stiffening};
  contacts.put(support);
}

// Whether a tip back inside is held out of a region by a border that its path lies on, ahead of it and behind: then it
// has the support of the nearer of the two vertices.
bool lies_on_border(const TissueView& tissue, const TipPlace& place);

}  // namespace acus
