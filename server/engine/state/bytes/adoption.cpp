// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/state/bytes/adoption.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "server/engine/state/bytes/state_bytes.h"
#include "server/engine/state/bytes/state_check.h"

namespace acus {

namespace {

void require(bool holds, const std::string& what) {
  if (!holds) throw AdoptionError("the state is of a scene with " + what + ", and cannot go on in this one");
}

void check_needles(const Model& model, const Model& from) {
  require(model.needle_count() == from.needle_count(), "another number of needles");
  for (int i = 0; i < model.needle_count(); ++i) {
    const NeedleModel &ours = model.needles[i], &theirs = from.needles[i];
    const std::string& name = from.scene.needles[i].name;
    require(model.scene.needles[i].name == name, "other names of needles");
    require(ours.nodes() == theirs.nodes() && ours.length == theirs.length, "another length or other beams of '" + name + "'");
  }
}

void check_tissue(const Model& model, const Model& from) {
  const TetrahedralMesh &ours = model.mesh, &theirs = from.mesh;
  require(ours.nodes.cols() == theirs.nodes.cols() && ours.nodes == theirs.nodes && ours.tetrahedra == theirs.tetrahedra,
          "another mesh");
  require(model.regions == from.regions, "other regions");
  require(model.tissue.branches == from.tissue.branches, "another number of branches of relaxation");
}

// Nodes go on as fast as they are; what a deferred field has besides is how it gets there.
void leave_field(TissueState& tissue) {
  if (!tissue.field) return;
  tissue.field.reset();
  tissue.moved = false;  // there is no balance of the tick before
  tissue.inertia.setZero();
}

void go_on_at(double h, double from_h, State& state) {
  const auto counted = [&](std::uint64_t tick) {
    return static_cast<std::uint64_t>(std::llround(static_cast<double>(tick) * from_h / h));
  };
  const auto begin = [&](BaseState& motion) {
    motion.command_tick = std::min(counted(motion.command_tick), state.tick);
    motion.rhythm = {};
  };
  state.tick = counted(state.tick);
  for (BaseState& base : state.bases) begin(base);
  for (GuideState& guide : state.guides) begin(guide.motion);
}

}  // namespace

State adopt(const Model& model, const Model& from, const State& state) {
  check_needles(model, from);
  require(model.guide_count() == from.guide_count() && model.guide_needles == from.guide_needles, "other guides");
  check_tissue(model, from);
  if (model.tissue_system.field)
    throw AdoptionError(
        "a scene with tissue.window cannot go on from a state of another one; load it with tissue.window: 0");
  State adopted = make_state(model);
  State whole = state;
  leave_field(whole.tissue);
  try {
    from_bytes(to_bytes(whole), adopted);
    if (model.h != from.h) go_on_at(model.h, from.h, adopted);
    check_state(model, adopted);
  } catch (const std::runtime_error&) {  // spacing of paths, for instance
    throw AdoptionError("the state is of a scene whose paths or rows are counted otherwise, and cannot go on in this one");
  }
  adopted.economizing = false;
  return adopted;
}

}  // namespace acus
