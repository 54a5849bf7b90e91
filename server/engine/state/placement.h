// SPDX-License-Identifier: GPL-3.0-or-later
// Needles and guides put elsewhere than where their scene has them, before the first tick: with one model, which has
// the factor of the tissue, insertions begin anywhere.
#pragma once

#include <optional>
#include <span>
#include <stdexcept>
#include <string>

#include "server/engine/state/model.h"
#include "server/engine/state/state.h"

namespace acus {

// A body cannot stand there; what() is a sentence.
struct PlacementError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// Of a needle or, after the needles, a guide.
const std::string& body_name(const Scene& scene, int body);

// Puts a body (a needle, or after the needles a guide) at `pose` (world, unit orientation), as if its scene had it
// there. `state` is one after loading. Throws PlacementError for a needle whose tip would be inside the tissue, and the
// state is as it was.
void place_body(const Model& model, State& state, int body, const Pose& pose);

// Two needles of which one is in the other.
struct Overlap {
  int first = 0, second = 0;
  double depth = 0;  // m, where it is deepest,
  double at = 0;     // m, along the second one
};
// Of the first two that are found, where the scene keeps needles apart.
std::optional<Overlap> find_overlap(const Model& model, std::span<const NeedleState> needles);
std::string sentence(const Scene& scene, const Overlap& overlap);

// Whether the tip of a straight or curved needle is inside the tissue, its nodes at x (3 x nodes, m), where its base is
// at `base`.
bool tip_is_inside(const Model& model, const Matrix3X& x, int needle, const Pose& base);

}  // namespace acus
