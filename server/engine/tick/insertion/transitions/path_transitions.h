// SPDX-License-Identifier: GPL-3.0-or-later
// Stage 9 of an insertion, at the new positions: contact, release, puncture, borders, growth of the path, exit,
// withdrawal. Changes the state of the next tick.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "server/engine/tick/insertion/transitions/transition.h"

namespace acus {

// Returns flags.
std::uint32_t insertion_transitions(const Transition& now);

// The patch that a tip will touch first if it continues for `distance` (m): outside along its axis, inside along its
// cutting direction.
std::optional<ContactPatch> patch_ahead(const InsertionView& at, const Insertion& state, std::span<const Path> paths,
                                        double distance);
// The tetrahedron at `distance` (m) ahead of a pushed tip along its cutting direction; -1 if the tip is in an old path
// or touches nothing.
int tetrahedron_ahead(const InsertionView& at, const InsertionScratch& scratch, const Insertion& state,
                      std::span<const Path> paths, double distance);

}  // namespace acus
