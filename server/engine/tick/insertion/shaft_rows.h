// SPDX-License-Identifier: GPL-3.0-or-later
// The rows of a path vertex alongside the shaft: two across the path, friction along it, torsion about it.
//
// The friction threshold is l pi d mu p, l the owned length of the vertex (owned_lengths.h). The lateral rows have the
// compliance of the tissue beside the shaft that the mesh does not resolve (foundation_compliance()) over the supported
// length.
//
// With tissue.local_compliance `all` the friction row has a spring e = axial/l, axial (m²/N) that of
// axial_compliance(). Its delta is the slip,
//
//   delta = W lambda + delta_free + e (lambda - lambda_n),       lambda_n = l t_n,
//
// t_n the traction, the friction per length at the end of the last tick. The traction, and so the strain of the tissue
// beside the vertex, is kept when l changes. A vertex that comes alongside takes over the traction of the one before
// it. The last one alongside takes over friction and length of the vertices that the tip is pulled past. So the force
// is continuous as vertices come and go, and no energy is made: a shaft that slips in stores axial t²/2 per metre; a
// shaft that sticks moves in and out within the stretch of the spring, which gives back what it stored. Where the
// stretch is a large part of l, lambda_n is at most the last friction: l t_n would grow with the motion that the spring
// has to resist.
//
// In tissue that relaxes the springs do, too (spring_memory.h).
//
// Torsional friction, if the needle has it, is one more row (rows.h), in one cone with the friction row
// (laws/friction_cone.h). Its slip is taken at the needle's radius times torsional_friction, so that this is the share
// of the friction force that resists spin. Friction with neither threshold nor viscosity has no row.
#pragma once

#include "server/engine/laws/rows.h"
#include "server/engine/tick/insertion/insertion.h"

namespace acus {

// False if a row did not fit.
bool add_shaft_rows(const InsertionView& at, const Path& path, const InsertionScratch& scratch, const ShaftPoint& point,
                    Rows& rows);

}  // namespace acus
