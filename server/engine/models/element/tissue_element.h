// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace acus {

// What a tetrahedron's volume change means (section "Elements" of MODEL.md): `linear` answers its own
// (corotational_tetrahedron.h), `nodal_pressure` mostly the mean around its nodes, which does not lock
// (nodal_pressure.h).
enum class TissueElement { linear, nodal_pressure };

}  // namespace acus
