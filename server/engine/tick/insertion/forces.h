// SPDX-License-Identifier: GPL-3.0-or-later
// What the laws' forces mean for one needle.
#pragma once

#include "server/engine/laws/rows.h"
#include "server/engine/tick/insertion/insertion.h"

namespace acus {

// Forces of the tissue on the needle by law; N, world. Their sum but for the tip's is all the tissue does to it.
struct InsertionForces {
  Vector3 tip = Vector3::Zero();       // cutting or contact, and lateral
  Vector3 cutting = Vector3::Zero();   // on the tip along its way: contact with a surface or border, cutting
  Vector3 friction = Vector3::Zero();  // along the path, whole shaft
  Vector3 lateral = Vector3::Zero();   // across the path, shaft and tip
};

// After the solve: what the needle will remember of the forces, into work.next, and which caps they reached.
InsertionForces read_forces(const Rows& rows, int needle, InsertionWork& work);

}  // namespace acus
