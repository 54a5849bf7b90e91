// SPDX-License-Identifier: GPL-3.0-or-later
// A state as one blob, from which any simulation of the same scene continues bit by bit: in another process, and on
// another machine of the same kind.
//
//   bytes    what
//   8        "acussnap"
//   8        version: of the names, the order and the sizes of what a state holds, and of what a tick makes of it
//   8        fingerprint of the scene
//   8        n
//   n        image of the state (state_bytes.h)
//   8        XXH3 of all before
//
// Numbers are little-endian. A checksum finds damage, not intent: all that a tick uses as an index or a size is
// checked, too.
#pragma once

#include <cstddef>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "server/engine/state/model.h"
#include "server/engine/state/state.h"

namespace acus {

// The blob cannot be used; what() is a sentence that says why.
struct SnapshotError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// `fingerprint` is the model's.
std::vector<std::byte> make_snapshot(std::uint64_t fingerprint, const State& state);

// Throws SnapshotError.
State read_snapshot(const Model& model, std::span<const std::byte> snapshot);

// Whether a file that begins so is one.
bool begins_as_snapshot(std::string_view beginning);

}  // namespace acus
