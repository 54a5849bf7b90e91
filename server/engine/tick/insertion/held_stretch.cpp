// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/tick/insertion/held_stretch.h"

namespace acus {

HeldStretch held_stretch(const InsertionView& at, const Located& located, const Insertion& state) {
  const double length = at.needle.model.length;
  const double beyond =
      kContactMargin + (located.obstacle ? located.obstacle->dimple.depth(state.tip.contact.along) : 0);
  if (state.path < 0) return {length, length, length - 2 * beyond};
  if (state.phase != Phase::through) return {std::min(length - state.depth, state.vertices[0].s), length, length};
  const double end = std::min(length, state.end_s);
  return {std::min(end - state.depth, state.vertices[0].s), end, length - 2 * beyond};
}

}  // namespace acus
