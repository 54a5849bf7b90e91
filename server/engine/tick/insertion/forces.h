// SPDX-License-Identifier: GPL-3.0-or-later
// The forces of the laws, summed up for one needle.
#pragma once

#include "server/engine/laws/rows.h"
#include "server/engine/tick/insertion/insertion.h"

namespace acus {

// Forces of the tissue on the needle by law; N, world. cutting + friction + lateral is the whole force of the tissue.
struct InsertionForces {
  Vector3 tip = Vector3::Zero();       // on the tip: cutting or contact, and lateral
  Vector3 cutting = Vector3::Zero();   // of cutting, and of contact with a surface or border
  Vector3 friction = Vector3::Zero();  // along the path, whole shaft; along surfaces that the shaft lies on
  Vector3 lateral = Vector3::Zero();   // across the path, shaft and tip; of those surfaces on the shaft
  double amounts = 0;                  // N, of all rows but torsion, added up
};

// After the solve: sets the forces in scratch.next, and scratch.puncturing and scratch.cutting where they reached a
// cap.
InsertionForces read_forces(const Rows& rows, int needle, InsertionScratch& scratch);

}  // namespace acus
