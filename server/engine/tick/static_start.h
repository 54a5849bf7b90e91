// SPDX-License-Identifier: GPL-3.0-or-later
// Where a world begins, as Scene::start says: undeformed, or in static equilibrium,
//
//   f(x) = applied + Hᵀ lambda,   v = 0,
//
// f being the elastic forces of tissue that has relaxed, applied weight and pressures, Hᵀ lambda what needles and
// guides do where they touch something. The same holds of the needles.
//
// Ticks of 1 s find it, without damping and with relaxations that are over within one, until no node moves by more than
// kSettled: 10 ticks where the tissue is hardly strained, 100 where it hangs by its side. They use the factor of the
// rest shape (`exact`: of the current one). Loading takes one more factorisation, with a window two or three.
//
// Of tissue with a window (models/field/deferred_field.h), what a needle in contact does comes in the first tick: its
// force is off by up to 8 % in the first windows (`tests/tick/test_static_start.cpp`).
#pragma once

#include <map>
#include <optional>

#include "server/engine/state/model.h"
#include "server/engine/state/state.h"

namespace acus {

inline constexpr double kSettlingRate = 1;    // Hz
inline constexpr double kSettled = 1e-9;      // m, in a tick
inline constexpr int kMaxSettlingTicks = 1000;
inline constexpr int kMaxCrushedTicks = 100;  // in a row, elements being flat or inside out

// The scene in equilibrium, as a state of its copy that settles; nothing where it starts undeformed. Reads the scene's
// mesh if that is not at hand. Throws SceneError where there is none: nothing holds the tissue, it is pressed flat,
// comes to no rest, or has come over the tip of a needle.
std::optional<State> settle(const Scene& scene, const Progress& progress, std::optional<TetrahedralMesh>& own_mesh);

// The tissue in equilibrium, for the scene's model; null where it starts undeformed.
inline const TissueState* tissue_of(const std::optional<State>& settled) {
  return settled ? &settled->tissue : nullptr;
}

// The state after loading, tick 0. `places`: of bodies, needles and after them guides, that stand elsewhere than in the
// scene (world, unit orientation); they hang there as their weight bends them. Throws PlacementError for a tip inside
// the tissue, and for a needle that touches it where the scene has it: the tissue is bent by that.
State start_state(const Model& model, const std::optional<State>& settled, const std::map<int, Pose>& places = {});

}  // namespace acus
