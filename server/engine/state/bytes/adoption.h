// SPDX-License-Identifier: GPL-3.0-or-later
// A state of one scene goes on in another that differs in numbers alone: materials, interactions, the direction of a
// bevel, the rate. Variants of a running world, with other values of what is not known, branch in this way.
//
// Places, velocities, paths and forces of the laws stay; the first ticks carry what the other numbers make of them.
// Where the rate differs, ticks are counted so that simulation time goes on, to half a tick, and the rhythm of commands
// begins anew. Tissue that relaxes has as many branches in both.
#pragma once

#include <stdexcept>

#include "server/engine/state/model.h"
#include "server/engine/state/state.h"

namespace acus {

// The two scenes differ in more; what() says in what.
struct AdoptionError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// `state` is of `from`. Throws AdoptionError.
State adopt(const Model& model, const Model& from, const State& state);

}  // namespace acus
