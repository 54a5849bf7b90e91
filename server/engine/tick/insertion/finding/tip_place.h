// SPDX-License-Identifier: GPL-3.0-or-later
// The place of the tip in its path (location.h explains it), and the border ahead of the tip: the border of a region
// that holds tips (state/borders.h) is a surface inside the tissue.
#pragma once

#include <optional>

#include "server/engine/tick/insertion/insertion.h"

namespace acus {

// Fills in located.tip but for its supported length (share_length). Needs the places along the needle of the path's
// vertices and end.
void place_tip(const InsertionView& at, const Path& path, InsertionScratch& scratch);

// The last point of the segment from `from` to `to` that a path can reach: it ends where the tissue does, and at
// borders that hold tips, or, `torn`, at those of bone; then `border` is the region behind, else -1.
struct Reached {
  MaterialPoint end;
  int border = -1;
  bool left = false;  // it ends where the tissue does
};
Reached reach_to(const TissueView& tissue, const MaterialPoint& from, const Vector3& to, bool torn = false);

// The first border that holds tips on the straight way from a path's end to a place: its region, and where.
struct BorderPlace {
  int region = 0;
  Vector3 place;  // m
};
std::optional<BorderPlace> first_border(const TissueView& tissue, const Path& path, const Vector3& to);

// Sets located.obstacle to the border that the tip touches, or may reach in this tick. A tip that is not quite at the
// end of its path may get there, and further, in this tick. From where it presses on it, what the end of its path has
// borne in the last tick is what the border has (press_on_border()).
void find_border(const InsertionView& at, const Path& path, InsertionScratch& scratch);

}  // namespace acus
