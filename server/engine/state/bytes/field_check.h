// SPDX-License-Identifier: GPL-3.0-or-later
// Whether the deferred field of a state that came from outside fits its window and its model.
#pragma once

#include "server/engine/state/bytes/state_bounds.h"
#include "server/engine/state/model.h"
#include "server/engine/state/state.h"

namespace acus {

// Throws std::runtime_error that names what does not.
void check_field(const Model& model, const FieldState& field, const StateBounds& bounds);

}  // namespace acus
