// SPDX-License-Identifier: GPL-3.0-or-later
// Needles and guides put elsewhere than where their scene has them, before the first tick: with one model, which has
// the factor of the tissue, insertions begin anywhere.
#pragma once

#include <stdexcept>
#include <string>

#include "server/engine/state/model.h"
#include "server/engine/state/state.h"

namespace acus {

// A body cannot stand there; what() is a sentence.
struct PlacementError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// Of a needle or, after the needles, a guide.
const std::string& body_name(const Scene& scene, int body);

// Puts a body (a needle, or after the needles a guide) at `pose` (world, unit orientation), as if its scene had it
// there. `state` is one after loading. Throws PlacementError for a needle whose tip would be inside the tissue, and the
// state is as it was.
void place_body(const Model& model, State& state, int body, const Pose& pose);

}  // namespace acus
