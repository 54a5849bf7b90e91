// SPDX-License-Identifier: GPL-3.0-or-later
// The contacts of a path vertex alongside the shaft: across the path, and friction along it and about it.
//
// Friction has the threshold l pi d mu p, l the owned length (owned_lengths.h). Without threshold and viscosity it has
// no contact. The rows across have the compliance of foundation_compliance() over the supported length.
//
// With tissue.local_compliance `all` the friction row has a spring e = axial/l, axial that of axial_compliance():
//
//   delta = W lambda + delta_free + e (lambda - lambda_n),       lambda_n = l t_n,
//
// t_n (N/m) the traction, friction per length, at the end of the last tick. A vertex keeps its traction as l changes. A
// vertex that comes alongside takes over that of the one before it; the last one alongside takes over friction and
// length of vertices that the tip is pulled past. The force is then continuous and no energy is made. Where the stretch
// is a large part of l, |lambda_n| is at most the last friction. Springs relax with the tissue (spring_memory.h).
//
// Torsional friction is one more row, in one cone with friction (laws/friction_cone.h), with the slip at the needle's
// radius times torsional_friction.
#pragma once

#include "server/engine/tick/contact/contact.h"
#include "server/engine/tick/insertion/insertion.h"

namespace acus {

void find_vertex_contacts(const InsertionView& at, const Path& path, InsertionScratch& scratch, const ShaftPoint& point,
                          Contacts& contacts);

}  // namespace acus
