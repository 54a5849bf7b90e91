// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/state/placement.h"

#include <cassert>

#include "server/engine/state/clearance.h"

namespace acus {

const std::string& body_name(const Scene& scene, int body) {
  const int guide = body - static_cast<int>(scene.needles.size());
  return guide < 0 ? scene.needles[body].name : scene.guides[guide].name;
}

void place_body(const Model& model, State& state, int body, const Pose& pose) {
  assert(state.tick == 0);
  if (const int guide = body - model.needle_count(); guide >= 0) {
    state.guides[guide].motion = base_at(pose);
    return;
  }
  if (tip_is_inside(model.mesh, state.tissue.x, model.needles[body], pose))
    throw PlacementError("expected the needle's tip outside the tissue, found it inside; move the base back");
  state.needles[body] = make_needle_state(model.needles[body], pose);
  state.bases[body] = base_at(pose);
}

}  // namespace acus
