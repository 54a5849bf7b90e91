// SPDX-License-Identifier: GPL-3.0-or-later
// Whether a state that came from outside can be continued from.
#pragma once

#include "server/engine/state/model.h"
#include "server/engine/state/state.h"

namespace acus {

// Throws std::runtime_error that names what is wrong: a number that is not finite or beyond what the model can bear
// (state_bounds.h), an index out of range, parts that do not fit each other or a window (field_check.h).
void check_state(const Model& model, const State& state);

}  // namespace acus
