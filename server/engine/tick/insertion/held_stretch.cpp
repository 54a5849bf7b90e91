// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/tick/insertion/held_stretch.h"

namespace acus {

HeldStretch held_stretch(const InsertionView& at, const Located& located, const Insertion& state) {
  const double length = at.needle.model.length;
  if (state.path >= 0) {
    const double end = state.phase == Phase::through ? std::min(length, state.end_s) : length;
    return {std::min(end - state.depth, state.vertices[0].s), end};
  }
  if (state.phase != Phase::contact || !located.obstacle) return {length, length};
  const double beyond = kContactMargin + located.obstacle->dimple.depth(state.tip.contact);
  return {length - 2 * beyond, length};
}

}  // namespace acus
