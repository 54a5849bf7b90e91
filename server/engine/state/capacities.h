// SPDX-License-Identifier: GPL-3.0-or-later
// Room that is set aside at load: what needles and guides can need in one tick, at most.
#pragma once

#include <span>

#include "server/engine/scene/scene.h"

namespace acus {

// The smallest distance between the vertices of any path (m): a needle may pick up a path that another one has cut.
double least_spacing(std::span<const Needle> needles);

// Path vertices that the shaft can hold at once, `spacing` apart or further.
int max_shaft_points(const Needle& parameters, double spacing);
// Rows of an insertion in one tick, at most.
int max_insertion_rows(const Needle& parameters, double spacing);
// Rows of a guide.
inline constexpr int kMaxGuideRows = 3;

}  // namespace acus
