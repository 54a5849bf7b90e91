// SPDX-License-Identifier: GPL-3.0-or-later
// One Gauss-Seidel sweep: each row in turn moves to where its law's graph meets its line, the others frozen. A contact
// and its two rows of friction, which stand right behind it, move together (contact_block.h).
#pragma once

#include "server/engine/laws/solver/law_system.h"

namespace acus {

// `delta` must be that of `lambda`, and is kept so but for rounding errors.
void sweep(const LawSystem& system, const LawState& state);

}  // namespace acus
