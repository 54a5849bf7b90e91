// SPDX-License-Identifier: GPL-3.0-or-later
// A state as bytes, made from the fields() of its structs. The image holds for one model: numbers as this machine stores
// them, sizes before everything that has one.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "server/engine/state/state.h"

namespace acus {

// Of all bytes: equal states have equal hashes, and a difference in the last bit of one number shows.
std::uint64_t hash(const State& state);

// The same with `economizing` off, whatever it is: whether ticks are late is not the scene's to say.
std::uint64_t comparable_hash(const State& state);

std::vector<std::byte> to_bytes(const State& state);

// Overwrites a state of the same model. Throws std::runtime_error, and leaves the state as it was, if the image is not one
// of such a state.
void from_bytes(std::span<const std::byte> bytes, State& state);

// Of all that are not whole, by its magnitude; infinite if one is not a number.
double largest_number(const State& state);

// Of the names, kinds and sizes of what a state holds: images of another layout are of another version.
std::uint64_t state_layout();

bool identical(const State& a, const State& b);

}  // namespace acus
