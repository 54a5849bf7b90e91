// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/state/placement.h"

#include <cassert>

#include "server/engine/models/surface.h"

namespace acus {

bool tip_is_inside(const Model& model, int needle, const Pose& base) {
  const Vector3 tip = make_needle_state(model.needles[needle], base).x.rightCols<1>();
  return model.mesh.tetrahedron_count() > 0 && find_tetrahedron(model.mesh, model.mesh.nodes, tip) >= 0;
}

void place_body(const Model& model, State& state, int body, const Pose& pose) {
  assert(state.tick == 0);
  if (const int guide = body - model.needle_count(); guide >= 0) {
    state.guides[guide].motion = base_at(pose);
    return;
  }
  if (tip_is_inside(model, body, pose))
    throw PlacementError("expected the needle's tip outside the tissue, found it inside; move the base back");
  state.needles[body] = make_needle_state(model.needles[body], pose);
  state.bases[body] = base_at(pose);
}

}  // namespace acus
