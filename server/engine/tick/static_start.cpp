// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/tick/static_start.h"

#include <algorithm>

#include "server/engine/math/largest_move.h"
#include "server/engine/models/field/field_task.h"
#include "server/engine/models/geometry/surface.h"
#include "server/engine/scene/field_error.h"
#include "server/engine/scene/scene_fields.h"
#include "server/engine/state/capacities.h"
#include "server/engine/state/placement.h"
#include "server/engine/tick/step.h"

namespace acus {

namespace {

void undamp(Material& material) { material.rayleigh_mass = material.rayleigh_stiffness = 0; }

// The scene with long ticks, without damping, and with relaxations of a moment.
Scene settling(const Scene& scene) {
  Scene copy = scene;
  copy.rate = kSettlingRate;
  copy.tissue.window = 0;
  copy.tissue.window_thread = false;
  for (Region& region : copy.tissue.regions) {
    undamp(region.material);
    for (Relaxation& branch : region.material.relaxation) branch.time = kRelaxationTime.min;
  }
  for (Needle& needle : copy.needles) {
    undamp(needle.material);
    if (needle.hold) needle.hold->damping = needle.hold->angular_damping = 0;
  }
  return copy;
}

void refuse_unheld(const Model& model) {
  const bool held = !model.tissue.fixed_nodes.empty();
  if (held || model.tissue_system.empty() || model.tissue.applied.isZero(0)) return;
  throw scene_error(model.scene, "start",
                    "expected tissue that is held, found no fixed node, and gravity or pressures; fix some nodes by "
                    "tissue.fixed, or set start: undeformed");
}

// Neither a way in nor a path is known of a tip that the tissue has come over.
void refuse_covered_tips(const Model& model, const State& state) {
  if (model.mesh.tetrahedron_count() == 0) return;
  for (int i = 0; i < model.needle_count(); ++i) {
    const Insertion& insertion = state.insertions[i];
    const Vector3 tip = state.needles[i].x.rightCols<1>();
    const bool free = insertion.phase == Phase::free;
    if (insertion.path < 0 && !(free && find_tetrahedron(model.mesh, state.tissue.x, tip) >= 0)) continue;
    throw scene_error(
        model.scene, child_path("needles", static_cast<std::size_t>(i)) + ".base",
        "expected the needle's tip outside the tissue in equilibrium, found it inside; move the base back");
  }
}

[[noreturn]] void refuse(const Scene& scene, const std::string& found) {
  throw scene_error(scene, "start",
                    "expected a static equilibrium, " + found +
                        "; take stiffer tissue, more of tissue.fixed or less of gravity and "
                        "tissue.pressures, or set start: undeformed");
}

double largest_move_of(const State& from, const State& to) {
  double way = largest_move(from.tissue.x, to.tissue.x);
  for (std::size_t i = 0; i < to.needles.size(); ++i)
    way = std::max(way, largest_move(from.needles[i].x, to.needles[i].x));
  return way;
}

State settled_state(const Model& model) {
  Scratch scratch(model);
  const Commands commands(model.needles.size() + static_cast<std::size_t>(model.guide_count()));
  State state = make_state(model);
  TickReport report;
  report.needles.resize(model.needles.size());
  report.events.reserve(scratch.events.capacity());
  double way = 0;
  int crushed = 0;  // ticks in a row
  for (int tick = 0; tick < kMaxSettlingTicks; ++tick) {
    const State before = state;
    step(model, commands, state, scratch, report);
    if (report.flags & kNotFinite) refuse(model.scene, "found positions that are no numbers");
    way = largest_move_of(before, state);
    const bool rests = way <= kSettled && !(report.flags & kStepLimited);
    crushed = report.flags & kElementsInverted ? crushed + 1 : 0;
    if (crushed == kMaxCrushedTicks || (crushed > 0 && rests))
      refuse(model.scene, "found elements of the tissue pressed flat or inside out");
    if (rests) return state;
  }
  refuse(model.scene, "found none within " + std::to_string(kMaxSettlingTicks) + " steps: nodes still move by " +
                          format_number(way) + " m");
}

void take_over(const Model& model, const State& settled, State& state) {
  state.tissue.x = settled.tissue.x;
  state.tissue.rotations = settled.tissue.rotations;
  state.tissue.crept = settled.tissue.crept;
  if (state.tissue.field) {
    state.tissue.field = make_field_state(model.tissue_system, max_held_nodes(model.scene), &state.tissue);
  } else {  // the first tick completes the balance of forces
    state.tissue.support = settled.tissue.support;
    state.tissue.moved = true;
    state.balance = settled.balance;
  }
  for (std::size_t i = 0; i < state.needles.size(); ++i) {
    state.needles[i].x = settled.needles[i].x;
    state.needles[i].q = settled.needles[i].q;
  }
  state.insertions = settled.insertions;
  state.guides = settled.guides;
  state.surface_moved = settled.surface_moved;
  state.spring_energy = settled.spring_energy;
}

// Needles and guides at these places bend as in the scene without tissue.
void bend(const Model& model, const std::map<int, Pose>& places, State& state) {
  Scene scene = model.scene;
  scene.tissue.rung = TissueRung::none;
  scene.needle_contact.enabled = false;
  std::vector<bool> moved(scene.needles.size());
  for (const auto& [body, pose] : places) {
    const int guide = body - model.needle_count();
    (guide < 0 ? scene.needles[body].base : scene.guides[guide].pose) = pose;
    moved[guide < 0 ? body : model.guide_needles[guide]] = true;
  }
  std::optional<TetrahedralMesh> no_mesh = TetrahedralMesh{};
  const std::optional<State> bent = settle(scene, {}, no_mesh);
  for (std::size_t i = 0; i < moved.size(); ++i)
    if (moved[i]) state.needles[i].x = bent->needles[i].x, state.needles[i].q = bent->needles[i].q;
  for (int g = 0; g < model.guide_count(); ++g)
    if (moved[model.guide_needles[g]]) state.guides[g] = bent->guides[g];
}

}  // namespace

std::optional<State> settle(const Scene& scene, const Progress& progress, std::optional<TetrahedralMesh>& own_mesh) {
  if (scene.start == Start::undeformed) return std::nullopt;
  if (!own_mesh) own_mesh = read_mesh(scene);
  if (progress) progress("equilibrium");
  const Model model(settling(scene), {}, own_mesh);
  refuse_unheld(model);
  State state = settled_state(model);
  refuse_covered_tips(model, state);
  return state;
}

State start_state(const Model& model, const std::optional<State>& settled, const std::map<int, Pose>& places) {
  State state = make_state(model);
  if (settled) take_over(model, *settled, state);
  for (const auto& [body, pose] : places) {
    try {
      if (body < model.needle_count() && state.insertions[body].phase != Phase::free)
        throw PlacementError("the tissue lies against it where the scene has it; move its base back there");
      place_body(model, state, body, pose);
    } catch (const PlacementError& error) {
      throw PlacementError("the place of '" + body_name(model.scene, body) + "': " + error.what());
    }
  }
  if (settled && !places.empty()) bend(model, places, state);
  return state;
}

}  // namespace acus
