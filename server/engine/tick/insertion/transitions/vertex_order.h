// SPDX-License-Identifier: GPL-3.0-or-later
// The order of a path's vertices along the needle in it, after they have been moved (tearing.h). A mouth that slides
// along a surface which is not across the needle comes nearer to the next vertex along the needle, and past it, or leaves it
// behind. Vertices that are too near to each other become one; between two that are too far apart comes another.
#pragma once

#include "server/engine/tick/insertion/transitions/transition.h"

namespace acus {

// A mouth of the path, or an exit with air behind it.
bool is_rim(const Path& path, int vertex);

// With what the needle has of it.
void remove_vertex(Path& path, Insertion& state, int vertex);

// Of the vertices alongside in this tick. Mouths and exits stay.
void keep_order(const Transition& now, Path& path);

}  // namespace acus
