// SPDX-License-Identifier: GPL-3.0-or-later
// Where the tip stands in its path; location.h says what it is held to there.
#pragma once

#include "server/engine/tick/insertion/insertion.h"

namespace acus {

// Fills in located.tip but for the length that holds it (share_length). Needs the places along the needle of the path's
// vertices and end.
void place_tip(const InsertionView& at, const Path& path, InsertionWork& work);

}  // namespace acus
