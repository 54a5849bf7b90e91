// SPDX-License-Identifier: GPL-3.0-or-later
// Stage 9 of an insertion, at the new positions: contact, release, puncture, borders, growth of the path, exit, withdrawal.
// Works on the state of the next tick.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "server/engine/tick/insertion/transition.h"

namespace acus {

// Returns flags.
std::uint32_t insertion_transitions(const Transition& now);

// What a tip outside will touch first if it goes on along its axis for `distance` (m).
std::optional<ContactPatch> patch_ahead(const InsertionView& at, const Insertion& memory, double distance);
// The tetrahedron that a pushed tip gets to in `distance` (m) along its cutting direction, -1 if it lies in an old path
// or touches nothing.
int tetrahedron_ahead(const InsertionView& at, const InsertionWork& work, const Insertion& memory,
                      std::span<const Path> paths, double distance);

}  // namespace acus
