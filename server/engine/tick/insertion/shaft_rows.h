// SPDX-License-Identifier: GPL-3.0-or-later
// The rows of a path vertex alongside the shaft: two across the path, friction along it, torsion about it.
//
// The friction threshold is l pi d mu p, l the length of needle that the vertex owns. The shaft lies off its path by the
// lateral force times the compliance of the tissue beside it that the mesh does not resolve (foundation_compliance()),
// shared out over the lengths that the vertices own.
//
// With tissue.local_compliance `all` a spring e = axial/l stands in the friction row, axial (m²/N) that of
// axial_compliance(). Its delta is the slip,
//
//   delta = W lambda + delta_free + e (lambda - lambda_n),       lambda_n = l t_n,
//
// t_n the friction per length that the vertex bore at the end of the last tick. It is this, and so the strain of the
// tissue beside it, that stays when l changes; a vertex that comes alongside takes over that of the one before it, and
// what vertices bore that the tip is pulled past goes with their length to the last one alongside, which makes no energy.
// So force is continuous as vertices come and go. What a shaft that slips enters with comes along with its share of
// energy, axial t²/2 per metre. A shaft that sticks goes in and out as far as the spring gives way, which gives back what
// it took. Where that is much of l itself, lambda_n is no more than the vertex bore: l t_n would grow with the motion that
// the spring is to hold.
//
// Torsional friction, if the needle has it, is one more row (rows.h) with the threshold of the friction row times the
// needle's share. Friction with neither threshold nor viscosity has no row.
#pragma once

#include "server/engine/laws/rows.h"
#include "server/engine/tick/insertion/insertion.h"

namespace acus {

// False if a row did not fit.
bool add_shaft_rows(const InsertionView& at, const Path& path, const InsertionWork& work, const ShaftPoint& point,
                    Rows& rows);

}  // namespace acus
